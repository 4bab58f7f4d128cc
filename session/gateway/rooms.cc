// SPDX-License-Identifier: Apache-2.0
#include "session/gateway/rooms.h"

#include "mapping/base/log.h"
#include "session/wire/frames.h"

namespace waymark::session::internal {

void GatewayRooms::Room::Tell(const PoseBatch& batch) {
  const wire::Downward message(batch);
  const wire::SharedFrame frame = wire::Share(wire::EncodeFrame(message));
  const std::lock_guard lock(mutex);
  for (const PhonePtr& phone : phones) phone->Tell(frame, wire::SlotOf(message));
}

void GatewayRooms::Enter(const PhonePtr& phone) {
  const std::lock_guard lock(mutex_);
  OpenRoom& open = open_[phone->room()];
  if (!open.room) {
    open.room = std::make_shared<Room>();
    auto ear =
        wire::RoomEar::Create(participant_, phone->room(),
                              [room = open.room](const PoseBatch& batch) { room->Tell(batch); });
    if (ear) {
      open.ear = *std::move(ear);
    } else {
      LogWarning("room {}: no poses: {}", phone->room().text(), ToString(ear.error()));
    }
  }
  const std::lock_guard room_lock(open.room->mutex);
  open.room->phones.insert(phone);
}

void GatewayRooms::Leave(const PhonePtr& phone) {
  OpenRoom closed;  // destroyed after the lock: its handler may be at work
  const std::lock_guard lock(mutex_);
  const auto found = open_.find(phone->room());
  if (found == open_.end()) return;
  bool is_empty = false;
  {
    const std::lock_guard room_lock(found->second.room->mutex);
    found->second.room->phones.erase(phone);
    is_empty = found->second.room->phones.empty();
  }
  if (!is_empty) return;
  closed = std::move(found->second);
  open_.erase(found);
}

}  // namespace waymark::session::internal
