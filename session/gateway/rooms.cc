// SPDX-License-Identifier: Apache-2.0
#include "session/gateway/rooms.h"

namespace waymark::session::internal {

Result<std::shared_ptr<Room>> GatewayRooms::Enter(const std::shared_ptr<Phone>& phone,
                                                  const RoomId& room) {
  const std::lock_guard lock(mutex_);
  auto found = open_.find(room);
  if (found == open_.end()) {
    WAYMARK_TRY_ASSIGN(auto opened, Room::Open(lines_.ParticipantOf(room), room, relay_, loop_));
    found = open_.emplace(room, std::move(opened)).first;
  }
  found->second->Enter(phone);
  return found->second;
}

void GatewayRooms::Leave(const std::shared_ptr<Phone>& phone, const RoomId& room) {
  std::shared_ptr<Room> closed;  // destroyed after the lock: its threads may be at work
  const std::lock_guard lock(mutex_);
  const auto found = open_.find(room);
  if (found == open_.end() || !found->second->Leave(phone)) return;
  closed = std::move(found->second);
  open_.erase(found);
}

}  // namespace waymark::session::internal
