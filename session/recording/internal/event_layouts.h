// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/recording/internal/message_layouts.h"
#include "session/state/events.h"

/// What happens to a session, as layouts.h says.
namespace waymark::session::recording::internal {

template <typename Archive>
void Visit(Archive&, event::Ticked&) {}

template <typename Archive>
void Visit(Archive& archive, event::Permit& value) {
  auto& [refusal, role, token_id, token_key, is_bound, until, owner] = value;
  archive(refusal, role, token_id, token_key, is_bound, until, owner);
}

inline event::HelloReceived Blank(Here, std::type_identity<event::HelloReceived>) {
  return {.hello = Blank(Here(), std::type_identity<Hello>())};
}
template <typename Archive>
void Visit(Archive& archive, event::HelloReceived& value) {
  auto& [hello, ticket, permit] = value;
  archive(hello, ticket, permit);
}

inline event::DeviceLeft Blank(Here, std::type_identity<event::DeviceLeft>) {
  return {.device = DeviceId("")};
}
template <typename Archive>
void Visit(Archive& archive, event::DeviceLeft& value) {
  auto& [device, said_goodbye] = value;
  archive(device, said_goodbye);
}

template <typename Archive>
void Visit(Archive& archive, event::Heard& value) {
  auto& [ticket] = value;
  archive(ticket);
}

template <typename Archive>
void Visit(Archive& archive, event::PoseReceived& value) {
  auto& [report] = value;
  archive(report);
}

inline event::CommandReceived Blank(Here, std::type_identity<event::CommandReceived>) {
  return {.command = Blank(Here(), std::type_identity<AnchorCommand>())};
}
template <typename Archive>
void Visit(Archive& archive, event::CommandReceived& value) {
  auto& [command] = value;
  archive(command);
}

inline event::RoomLoaded Blank(Here, std::type_identity<event::RoomLoaded>) {
  return {.room = RoomId(""), .revision = {}, .anchors = {}};
}
template <typename Archive>
void Visit(Archive& archive, event::RoomLoaded& value) {
  auto& [room, revision, anchors] = value;
  archive(room, revision, anchors);
}

inline event::WriteFinished::Applied Blank(Here,
                                           std::type_identity<event::WriteFinished::Applied>) {
  return {.anchor = Blank(Here(), std::type_identity<RoomAnchor>())};
}
template <typename Archive>
void Visit(Archive& archive, event::WriteFinished::Applied& value) {
  auto& [anchor] = value;
  archive(anchor);
}

template <typename Archive>
void Visit(Archive& archive, event::WriteFinished::Conflict& value) {
  auto& [current] = value;
  archive(current);
}

inline std::variant<event::WriteFinished::Applied, event::WriteFinished::Conflict> Blank(
    Here, std::type_identity<
              std::variant<event::WriteFinished::Applied, event::WriteFinished::Conflict>>) {
  return event::WriteFinished::Conflict{};
}

inline event::WriteFinished Blank(Here, std::type_identity<event::WriteFinished>) {
  return {.write = {}, .outcome = Error{ErrorCode::kCorrupt, ""}};
}
template <typename Archive>
void Visit(Archive& archive, event::WriteFinished& value) {
  auto& [write, outcome] = value;
  archive(write, outcome);
}

template <typename Archive>
void Visit(Archive& archive, event::StoreChanged& value) {
  auto& [changes] = value;
  archive(changes);
}

inline event::Localised Blank(Here, std::type_identity<event::Localised>) {
  return {.device = DeviceId(""), .submap = SubmapId("")};
}
template <typename Archive>
void Visit(Archive& archive, event::Localised& value) {
  auto& [device, submap] = value;
  archive(device, submap);
}

template <typename Archive>
void Visit(Archive& archive, event::ReleaseSwapped& value) {
  auto& [epoch, placements] = value;
  archive(epoch, placements);
}

template <typename Archive>
void Visit(Archive& archive, event::PermitsRevoked& value) {
  auto& [token_ids, devices, token_keys] = value;
  archive(token_ids, devices, token_keys);
}

template <typename Archive>
void Visit(Archive& archive, event::RoomCommandReceived& value) {
  auto& [command] = value;
  archive(command);
}

inline event::RoomPartLoaded Blank(Here, std::type_identity<event::RoomPartLoaded>) {
  return {.room = RoomId(""), .anchors = {}};
}
template <typename Archive>
void Visit(Archive& archive, event::RoomPartLoaded& value) {
  auto& [room, anchors] = value;
  archive(room, anchors);
}

template <typename Archive>
void Visit(Archive& archive, event::RulesFound& value) {
  auto& [rules] = value;
  archive(rules);
}

template <typename Archive>
void Visit(Archive& archive, event::RulesKept& value) {
  auto& [version, failure] = value;
  archive(version, failure);
}

template <typename Archive>
void Visit(Archive& archive, event::AreaReceived& value) {
  auto& [report] = value;
  archive(report);
}

}  // namespace waymark::session::recording::internal
