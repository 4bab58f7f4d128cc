// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "session/state/events.h"

namespace waymark::session {

/// A device that has joined.
struct RoomMember {
  DeviceId device;
  RoomId room;
  std::string name;
  Ticket ticket{};
  DeviceNumber number{};
  ServerTime last_heard;
  std::optional<LivePose> pose;
  bool pose_is_new = false;
  std::deque<SubmapId> found_in = {};  ///< by its latest images, newest first
  ServerTime pose_published;
  std::set<Uuid> under_way;           ///< commands that wait for the store
  std::deque<CommandReply> answered;  ///< oldest first, for repetitions
};

/// A room in memory. Its anchors are those that the store has acknowledged.
struct Room {
  bool is_open = false;                       ///< false: its anchors are being read
  std::vector<event::HelloReceived> waiting;  ///< while not open
  std::set<DeviceId> members;
  std::map<AnchorId, RoomAnchor> anchors;
  std::uint64_t revision = 0;
  std::uint64_t digest = 0;
  std::size_t writes_under_way = 0;
  ServerTime last_used;

  /// Brings an anchor to the state that the store acknowledged; a later state wins.
  void Put(const RoomAnchor& anchor);
  void Remove(const AnchorId& anchor, std::uint64_t revision_of_deletion);
};

}  // namespace waymark::session
