// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <variant>

#include "session/dds/participant.h"
#include "session/state/messages.h"

namespace waymark::session::wire {

/// Another device left, or was lost.
struct DeviceGone {
  DeviceId device;
};
/// An anchor was deleted.
struct AnchorGone {
  AnchorId anchor;
};

/// Anything the server may say.
using Downward = std::variant<Welcome, Presence, DeviceGone, PoseBatch, LocaliseAnswer, AnchorState,
                              AnchorGone, CommandReply, RoomState, MapState, ClockPong>;

/// A device's end of the star. Messages arrive, already checked, on DDS threads: the handler only
/// enqueues. Sending is thread-safe.
class DeviceBus {
 public:
  using Handler = std::function<void(Downward)>;

  static Result<std::unique_ptr<DeviceBus>> Create(const dds::ParticipantOptions& options,
                                                   const RoomId& room, const DeviceId& device,
                                                   Handler handler);
  ~DeviceBus();

  Result<void> Send(const Hello& hello);
  Result<void> Send(const PoseReport& report);
  Result<void> Send(const LocaliseQuery& query);
  Result<void> Send(const AnchorCommand& command);
  Result<void> Send(const ClockPing& ping);
  /// Says goodbye and waits a moment for the server to hear it.
  void SayFarewell();

 private:
  struct Impl;

  explicit DeviceBus(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace waymark::session::wire
