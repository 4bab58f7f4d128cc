// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "session/state/messages.h"

namespace waymark::session {

/// A device that a moderator removed from a room.
struct Ban {
  ServerTime until;
  std::string token_id;  ///< that it had come with; empty: none
  std::string reason;
};

/// What moderators decided; it outlives rooms and servers.
struct RoomRules {
  std::map<RoomId, std::uint32_t> capacities = {};  ///< devices; where it was set
  std::map<std::pair<RoomId, DeviceId>, Ban> bans = {};
};

}  // namespace waymark::session
