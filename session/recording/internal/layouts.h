// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/recording/internal/archive.h"
#include "session/recording/recording.h"
#include "session/state/events.h"

/// What recorded values are made of, in order. The bindings name every member, so that one more
/// does not compile until it is here, which makes another version of the format.
namespace waymark::session::recording::internal {

template <typename Archive>
void Visit(Archive& archive, Angle& angle) {
  double radians = angle.radians();
  archive(radians);
  angle = Angle::Radians(radians);
}
template <typename Archive>
void Visit(Archive&, event::Ticked&) {}

template <typename Archive>
void Visit(Archive& archive, waymark::GeoPoint& value) {
  auto& [latitude, longitude, height] = value;
  archive(latitude, longitude, height);
}

inline content::SubmapAttachment Blank(Here, std::type_identity<content::SubmapAttachment>) {
  return {.submap = SubmapId(""), .submap_from_anchor = {}};
}
template <typename Archive>
void Visit(Archive& archive, content::SubmapAttachment& value) {
  auto& [submap, pose] = value;
  archive(submap, pose);
}

template <typename Archive>
void Visit(Archive& archive, content::PayloadLink& value) {
  auto& [uri, sha256] = value;
  archive(uri, sha256);
}

inline content::AnchorRecord Blank(Here, std::type_identity<content::AnchorRecord>) {
  return {.id = AnchorId(""), .room = RoomId("")};
}
template <typename Archive>
void Visit(Archive& archive, content::AnchorRecord& value) {
  auto& [id, room, owner, pose, epoch, attachments, place, kind, payload, created, changed,
         revision, link, expires, visibility, editing, unsupported] = value;
  archive(id, room, owner, pose, epoch, attachments, place, kind, payload, created, changed,
          revision, link, expires, visibility, editing, unsupported);
}

inline content::AnchorChange Blank(Here, std::type_identity<content::AnchorChange>) {
  return {.revision = 0, .id = AnchorId(""), .room = RoomId(""), .record = {}};
}
template <typename Archive>
void Visit(Archive& archive, content::AnchorChange& value) {
  auto& [revision, id, room, record] = value;
  archive(revision, id, room, record);
}

inline RoomAnchor Blank(Here, std::type_identity<RoomAnchor>) {
  return {.record = Blank(Here(), std::type_identity<content::AnchorRecord>())};
}
template <typename Archive>
void Visit(Archive& archive, RoomAnchor& value) {
  auto& [record, is_supported] = value;
  archive(record, is_supported);
}

inline Hello Blank(Here, std::type_identity<Hello>) {
  return {.device = DeviceId(""), .room = RoomId(""), .name = ""};
}
template <typename Archive>
void Visit(Archive& archive, Hello& value) {
  auto& [device, protocol, attempt, room, name, token] = value;
  archive(device, protocol, attempt, room, name);
  (void)token;  // a secret
}

template <typename Archive>
void Visit(Archive& archive, LivePose& value) {
  auto& [epoch, time, pose, sigma, velocity, gaze] = value;
  archive(epoch, time, pose, sigma, velocity, gaze);
}

template <typename Archive>
void Visit(Archive& archive, PoseReport& value) {
  auto& [ticket, pose] = value;
  archive(ticket, pose);
}

template <typename Archive>
void Visit(Archive& archive, SharedPose& value) {
  auto& [number, pose] = value;
  archive(number, pose);
}

inline AnchorCommand Blank(Here, std::type_identity<AnchorCommand>) {
  return {.anchor = AnchorId("")};
}
template <typename Archive>
void Visit(Archive& archive, AnchorCommand& value) {
  auto& [ticket, request, operation, anchor, expected, epoch, pose, seen_in, kind, payload] = value;
  archive(ticket, request, operation, anchor, expected, epoch, pose, seen_in, kind, payload);
}

template <typename Archive>
void Visit(Archive& archive, RoomCommand& value) {
  auto& [ticket, request, operation, device, capacity, reason] = value;
  archive(ticket, request, operation, device, capacity, reason);
}

template <typename Archive>
void Visit(Archive& archive, MapIdentity& value) {
  auto& [map, is_geo_aligned, origin, epoch] = value;
  archive(map, is_geo_aligned, origin, epoch);
}

template <typename Archive>
void Visit(Archive& archive, Welcome& value) {
  auto& [device, attempt, verdict, reason, run, ticket, number, map, time, role, is_return] = value;
  archive(device, attempt, verdict, reason, run, ticket, number, map, time, role, is_return);
}

template <typename Archive>
void Visit(Archive& archive, Presence& value) {
  auto& [device, number, name, run, role] = value;
  archive(device, number, name, run, role);
}

template <typename Archive>
void Visit(Archive& archive, AnchorState& value) {
  auto& [run, anchor] = value;
  archive(run, anchor);
}

template <typename Archive>
void Visit(Archive& archive, RoomState& value) {
  auto& [room, run, revision, epoch, count, digest] = value;
  archive(room, run, revision, epoch, count, digest);
}

template <typename Archive>
void Visit(Archive& archive, MapState& value) {
  auto& [room, run, swap, epoch, placements] = value;
  archive(room, run, swap, epoch, placements);
}

template <typename Archive>
void Visit(Archive& archive, CommandReply& value) {
  auto& [device, request, outcome, reason, anchor, current] = value;
  archive(device, request, outcome, reason, anchor, current);
}

template <typename Archive>
void Visit(Archive& archive, event::Permit& value) {
  auto& [refusal, role, token_id, token_key, is_bound, until] = value;
  archive(refusal, role, token_id, token_key, is_bound, until);
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
void Visit(Archive& archive, StateOptions& value) {
  auto& [presence, return_within, ban, room_idle, pose_repeat, clock_error, rooms, members, anchors,
         writes, rights, opening] = value;
  archive(presence, return_within, ban, room_idle, pose_repeat, clock_error, rooms, members,
          anchors, writes, rights, opening);
}

template <typename Archive>
void Visit(Archive& archive, RecordingHeader& value) {
  auto& [options, run, map, placements, started] = value;
  archive(options, run, map, placements, started);
}

}  // namespace waymark::session::recording::internal
