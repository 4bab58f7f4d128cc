// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "session/dds/participant.h"
#include "session/wire/traffic.h"

namespace waymark::session::wire {

/// Hears the poses that the server tells a room, once for all the devices of a process in it.
class RoomEar {
 public:
  /// Called on DDS threads: it only enqueues. Never after the ear is destroyed.
  using Handler = std::function<void(PoseBatch)>;

  /// Errors: InvalidArgument (room), Unavailable.
  static Result<std::unique_ptr<RoomEar>> Create(std::shared_ptr<dds::Participant> participant,
                                                 const RoomId& room, Handler handler);
  ~RoomEar();

 private:
  struct Impl;

  explicit RoomEar(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace waymark::session::wire
