// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "session/gateway/bus_lines.h"
#include "session/gateway/room.h"

namespace waymark::session::internal {

/// The rooms that phones of this gateway stand in, opened for the first and closed after the last.
/// Thread-safe.
class GatewayRooms {
 public:
  GatewayRooms(const BusLines& lines, const RelayOptions& relay, socket::SocketLoop& loop)
      : lines_(lines), relay_(relay), loop_(loop) {}

  /// Errors: those of Room::Open.
  Result<std::shared_ptr<Room>> Enter(const std::shared_ptr<Phone>& phone, const RoomId& room);
  void Leave(const std::shared_ptr<Phone>& phone, const RoomId& room);

 private:
  const BusLines& lines_;
  const RelayOptions relay_;
  socket::SocketLoop& loop_;
  std::mutex mutex_;
  std::map<RoomId, std::shared_ptr<Room>> open_;  // guarded by mutex_
};

}  // namespace waymark::session::internal
