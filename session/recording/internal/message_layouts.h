// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/recording/internal/archive.h"
#include "session/state/messages.h"
#include "session/state/room_rules.h"

/// Anchors and messages, as layouts.h says.
namespace waymark::session::recording::internal {

template <typename Archive>
void Visit(Archive& archive, Angle& angle) {
  double radians = angle.radians();
  archive(radians);
  angle = Angle::Radians(radians);
}

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
  auto& [device, protocol, attempt, room, name, token, owner_secret, scope] = value;
  archive(device, protocol, attempt, room, name, scope);
  (void)token;  // a secret, as the next
  (void)owner_secret;
}

template <typename Archive>
void Visit(Archive& archive, LivePose& value) {
  auto& [epoch, time, pose, sigma, rotation_sigma, tracking, velocity, gaze] = value;
  archive(epoch, time, pose, sigma, rotation_sigma, tracking, velocity, gaze);
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
  auto& [ticket, request, operation, anchor, expected, epoch, pose, seen_in, kind, payload,
         visibility] = value;
  archive(ticket, request, operation, anchor, expected, epoch, pose, seen_in, kind, payload,
          visibility);
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
  auto& [device, attempt, verdict, reason, run, ticket, number, map, time, role, is_return,
         protocol, owner] = value;
  archive(device, attempt, verdict, reason, run, ticket, number, map, time, role, is_return,
          protocol, owner);
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
void Visit(Archive& archive, OwnerState& value) {
  auto& [owner, run, count, digest] = value;
  archive(owner, run, count, digest);
}

template <typename Archive>
void Visit(Archive& archive, AnchorArea& value) {
  auto& [centre_m, radius_m] = value;
  archive(centre_m.x(), centre_m.y(), radius_m);
}

template <typename Archive>
void Visit(Archive& archive, AreaReport& value) {
  auto& [ticket, number, area, is_anew] = value;
  archive(ticket, number, area, is_anew);
}

inline AreaState Blank(Here, std::type_identity<AreaState>) { return {.device = DeviceId("")}; }
template <typename Archive>
void Visit(Archive& archive, AreaState& value) {
  auto& [device, run, number, area, count, digest] = value;
  archive(device, run, number, area, count, digest);
}

template <typename Archive>
void Visit(Archive& archive, MapState& value) {
  auto& [room, run, swap, epoch, placements] = value;
  archive(room, run, swap, epoch, placements);
}

template <typename Archive>
void Visit(Archive& archive, Ban& value) {
  auto& [until, token_id, reason] = value;
  archive(until, token_id, reason);
}

template <typename Archive>
void Visit(Archive& archive, RoomRules& value) {
  auto& [capacities, bans] = value;
  archive(capacities, bans);
}

template <typename Archive>
void Visit(Archive& archive, CommandReply& value) {
  auto& [device, request, outcome, reason, anchor, current] = value;
  archive(device, request, outcome, reason, anchor, current);
}

}  // namespace waymark::session::recording::internal
