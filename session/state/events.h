// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "content_store/anchor_store.h"
#include "session/state/messages.h"
#include "session/state/room_rules.h"

/// What happens to a session, and what it then wants done.
namespace waymark::session {

/// One write to the store under way.
enum class WriteNumber : std::uint64_t {};

namespace event {

/// What the check of a token came to; by default, that of a server which asks for none.
struct Permit {
  std::string refusal = {};  ///< why not; empty: it may
  Role role = Role::kMember;
  std::string token_id = {};        ///< names the token without being it; empty: came with none
  std::string token_key = {};       ///< names the key that signed it
  bool is_for_this_device = false;  ///< as opposed to any
  std::optional<ServerTime> until = {};  ///< then it ends
  std::string owner = {};                ///< of what the device places; empty: the device itself
};
/// `fresh_ticket` is random and unused so far; it is taken only if the device is new. Token and
/// owner's secret are not in `hello` any more.
struct HelloReceived {
  Hello hello;
  Ticket fresh_ticket{};
  Permit permit = {};
};
struct DeviceLeft {
  DeviceId device;
  bool said_goodbye = true;  ///< false: its connection or process was lost, it may come back
};
/// These tokens, all of these devices, and all that these keys signed, count no more.
struct PermitsRevoked {
  std::set<std::string> token_ids;
  std::set<DeviceId> devices;
  std::set<std::string> token_keys = {};
};
struct RoomCommandReceived {
  RoomCommand command;
};
/// From a device that no gateway speaks for: gateways know what their phones are interested in.
struct AreaReceived {
  AreaReport report;
};
/// Any sign of life that carries nothing else: a ping, an image.
struct Heard {
  Ticket ticket{};
};
struct PoseReceived {
  PoseReport report;
};
struct CommandReceived {
  AnchorCommand command;
};
/// Some of the anchors of a room that holds many, before the RoomLoaded with its last ones.
struct RoomPartLoaded {
  RoomId room;
  std::vector<RoomAnchor> anchors;
};
/// The answer to effect::LoadRoom.
struct RoomLoaded {
  RoomId room;
  Result<std::uint64_t> revision;
  std::vector<RoomAnchor> anchors;
};
/// The answer to effect::WriteAnchor. A record comes as a RoomAnchor of the live epoch.
struct WriteFinished {
  struct Applied {
    RoomAnchor anchor;  ///< as stored; for a deletion its last state with the deletion's revision
  };
  struct Conflict {
    std::optional<RoomAnchor> current;
  };

  WriteNumber write{};
  Result<std::variant<Applied, Conflict>> outcome;
};
/// What the store's change feed tells, oldest first: everybody's writes, ours too.
struct StoreChanged {
  std::vector<content::AnchorChange> changes;
};
/// An image of the device was found in a submap.
struct Localised {
  DeviceId device;
  SubmapId submap;
};
/// Another release shall be live.
struct ReleaseSwapped {
  std::uint64_t epoch = 1;
  std::shared_ptr<const Placements> placements;  ///< of all its submaps
};
/// What had been decided before this session began.
struct RulesFound {
  RoomRules rules;
};
/// The answer to effect::KeepRules.
struct RulesKept {
  std::uint64_t version = 0;
  std::string failure = {};  ///< why they are not kept; empty: they are
};
/// Time has passed; comes kTicksPerFrame times in the period of a frame.
struct Ticked {};

}  // namespace event

using Event =
    std::variant<event::HelloReceived, event::DeviceLeft, event::Heard, event::PoseReceived,
                 event::CommandReceived, event::RoomLoaded, event::WriteFinished,
                 event::StoreChanged, event::Localised, event::ReleaseSwapped, event::Ticked,
                 event::PermitsRevoked, event::RoomCommandReceived, event::AreaReceived,
                 event::RoomPartLoaded, event::RulesFound, event::RulesKept>;

namespace effect {

/// Read a room's anchors and report event::RoomLoaded.
struct LoadRoom {
  RoomId room;
};
/// From now on there are publications to this room.
struct OpenRoom {
  RoomId room;
};
struct CloseRoom {
  RoomId room;
};
struct SendWelcome {
  RoomId room;
  Welcome welcome;
};
/// Nothing more will be said to this device.
struct CloseDevice {
  DeviceId device;
};
struct PublishPresence {
  RoomId room;
  Presence presence;
};
struct WithdrawPresence {
  RoomId room;
  DeviceId device;
};
/// All poses of a room that are due; whom they reach is up to a PoseRelay.
struct PublishPoses {
  RoomId room;
  RunId run{};
  std::uint32_t tick = 0;
  std::uint64_t epoch = 1;
  std::vector<SharedPose> poses;
};
struct PublishAnchor {
  RoomId room;
  AnchorState state;
};
struct WithdrawAnchor {
  RoomId room;
  AnchorId anchor;
};
struct PublishRoomState {
  RoomState state;
};
struct PublishMapState {
  MapState state;
};
/// From now on this release is live: images are found in it, and what is written holds on to it.
struct GoLive {
  std::uint64_t epoch = 1;
};
/// What a swap did to the anchors of all rooms, when the last of them is told; for the log.
struct ReportSwap {
  std::uint64_t epoch = 1;
  std::size_t carried = 0;
  std::size_t unsupported = 0;
  double max_motion_m = 0;
};
/// Write to the store and report event::WriteFinished. What only the store's side knows
/// (attachments to submaps, place, times) is filled in there.
struct WriteAnchor {
  WriteNumber write{};
  AnchorOperation operation = AnchorOperation::kCreate;
  content::AnchorRecord record;
  std::uint64_t expected_revision = 0;
  std::vector<SubmapId> seen_in;
};
struct SendReply {
  CommandReply reply;
};
/// Keep this in place of what was kept before, so that it outlives the server, and report
/// event::RulesKept. The next one comes only then.
struct KeepRules {
  std::uint64_t version = 0;
  RoomRules rules;
};
/// What a device's owner alone may see: all of it. What it was told before and is not in it is
/// over.
struct SendOwn {
  DeviceId device;
  std::vector<AnchorState> anchors;
  OwnerState state;
};
/// One change of it: an anchor as it is now, or that it is over.
struct SendOwnChange {
  DeviceId device;
  std::variant<AnchorState, AnchorId> change;
  OwnerState state;
};

/// What a device that asked for an area is told of it, in this order.
struct TellArea {
  DeviceId device;
  std::vector<AnchorState> anchors = {};
  std::vector<AnchorId> over = {};
  /// Of these it is told nothing; they do not matter to it any more.
  std::vector<AnchorId> leaving = {};
  std::optional<AreaState> state = {};
};

}  // namespace effect

using Effect =
    std::variant<effect::LoadRoom, effect::OpenRoom, effect::CloseRoom, effect::SendWelcome,
                 effect::CloseDevice, effect::PublishPresence, effect::WithdrawPresence,
                 effect::PublishPoses, effect::PublishAnchor, effect::WithdrawAnchor,
                 effect::PublishRoomState, effect::PublishMapState, effect::ReportSwap,
                 effect::WriteAnchor, effect::SendReply, effect::SendOwn, effect::SendOwnChange,
                 effect::TellArea, effect::GoLive, effect::KeepRules>;

}  // namespace waymark::session
