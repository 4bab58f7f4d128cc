// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "session/dds/participant.h"
#include "session/wire/traffic.h"

namespace waymark::session::wire {

/// A room's end of the star, shared by all the devices of a process in it: what the room is told is
/// heard once, and they speak through the same writers. Thread-safe.
class RoomLine {
 public:
  /// Called on DDS threads: it only enqueues. Never after what calls it is destroyed.
  using Handler = std::function<void(Downward)>;

  /// Hands over what all of the room are told: presences, anchors, states, and every pose; and what
  /// one of the devices is told, or one of another process: welcomes, answers and replies.
  /// `on_lost`: the server is away; when it is back, all that holds is told anew.
  /// Errors: InvalidArgument (room), Unavailable.
  static Result<std::unique_ptr<RoomLine>> Create(std::shared_ptr<dds::Participant> participant,
                                                  const RoomId& room, Handler handler,
                                                  std::function<void()> on_lost);
  ~RoomLine();

  /// Says what one of the devices says; poses and pings go by a GatewayLine.
  Result<void> Send(const Upward& message);
  /// The device is no longer here: to the server as if its process had ended.
  void Forget(const DeviceId& device);

 private:
  struct Impl;

  explicit RoomLine(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace waymark::session::wire
