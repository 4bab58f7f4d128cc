// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/recording/internal/message_layouts.h"
#include "session/state/events.h"

/// What a session does, as layouts.h says.
namespace waymark::session::recording::internal {

template <typename Archive>
void Visit(Archive& archive, effect::LoadRoom& value) {
  auto& [room] = value;
  archive(room);
}

template <typename Archive>
void Visit(Archive& archive, effect::OpenRoom& value) {
  auto& [room] = value;
  archive(room);
}

template <typename Archive>
void Visit(Archive& archive, effect::CloseRoom& value) {
  auto& [room] = value;
  archive(room);
}

template <typename Archive>
void Visit(Archive& archive, effect::SendWelcome& value) {
  auto& [room, welcome] = value;
  archive(room, welcome);
}

template <typename Archive>
void Visit(Archive& archive, effect::CloseDevice& value) {
  auto& [device] = value;
  archive(device);
}

template <typename Archive>
void Visit(Archive& archive, effect::PublishPresence& value) {
  auto& [room, presence] = value;
  archive(room, presence);
}

template <typename Archive>
void Visit(Archive& archive, effect::WithdrawPresence& value) {
  auto& [room, device] = value;
  archive(room, device);
}

template <typename Archive>
void Visit(Archive& archive, effect::PublishPoses& value) {
  auto& [room, run, tick, epoch, poses] = value;
  archive(room, run, tick, epoch, poses);
}

template <typename Archive>
void Visit(Archive& archive, effect::PublishAnchor& value) {
  auto& [room, state] = value;
  archive(room, state);
}

template <typename Archive>
void Visit(Archive& archive, effect::WithdrawAnchor& value) {
  auto& [room, anchor] = value;
  archive(room, anchor);
}

template <typename Archive>
void Visit(Archive& archive, effect::PublishRoomState& value) {
  auto& [state] = value;
  archive(state);
}

template <typename Archive>
void Visit(Archive& archive, effect::PublishMapState& value) {
  auto& [state] = value;
  archive(state);
}

template <typename Archive>
void Visit(Archive& archive, effect::GoLive& value) {
  auto& [epoch] = value;
  archive(epoch);
}

template <typename Archive>
void Visit(Archive& archive, effect::ReportSwap& value) {
  auto& [epoch, carried, unsupported, motion] = value;
  archive(epoch, carried, unsupported, motion);
}

template <typename Archive>
void Visit(Archive& archive, effect::WriteAnchor& value) {
  auto& [write, operation, record, expected, seen_in] = value;
  archive(write, operation, record, expected, seen_in);
}

template <typename Archive>
void Visit(Archive& archive, effect::SendReply& value) {
  auto& [reply] = value;
  archive(reply);
}

template <typename Archive>
void Visit(Archive& archive, effect::KeepRules& value) {
  auto& [version, rules] = value;
  archive(version, rules);
}

template <typename Archive>
void Visit(Archive& archive, effect::SendOwn& value) {
  auto& [device, anchors, state] = value;
  archive(device, anchors, state);
}

template <typename Archive>
void Visit(Archive& archive, effect::SendOwnChange& value) {
  auto& [device, change, state] = value;
  archive(device, change, state);
}

template <typename Archive>
void Visit(Archive& archive, effect::TellArea& value) {
  auto& [device, anchors, over, leaving, state] = value;
  archive(device, anchors, over, leaving, state);
}

}  // namespace waymark::session::recording::internal
