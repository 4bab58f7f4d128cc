// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <set>

#include "session/gateway/phone.h"
#include "session/wire/room_ear.h"

namespace waymark::session::internal {

/// The rooms that phones of this gateway stand in. Poses are heard and encoded once for each.
/// Thread-safe.
class GatewayRooms {
 public:
  using PhonePtr = std::shared_ptr<Phone>;

  explicit GatewayRooms(std::shared_ptr<dds::Participant> participant)
      : participant_(std::move(participant)) {}

  void Enter(const PhonePtr& phone);
  void Leave(const PhonePtr& phone);

 private:
  struct Room {
    std::mutex mutex;
    std::set<PhonePtr> phones;  // guarded by mutex

    void Tell(const PoseBatch& batch);
  };
  struct OpenRoom {
    std::shared_ptr<Room> room;
    std::unique_ptr<wire::RoomEar> ear;
  };

  const std::shared_ptr<dds::Participant> participant_;
  std::mutex mutex_;
  std::map<RoomId, OpenRoom> open_;  // guarded by mutex_
};

}  // namespace waymark::session::internal
