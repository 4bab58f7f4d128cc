// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "session/dds/participant.h"
#include "session/wire/device_link.h"

namespace waymark::session::wire {

/// A device's end of the star over DDS.
class DeviceBus final : public DeviceLink {
 public:
  /// It hears of the room's anchors, or of those of the areas that it asks for.
  /// Errors: InvalidArgument (room, device), Unavailable.
  static Result<std::unique_ptr<DeviceBus>> Create(std::shared_ptr<dds::Participant> participant,
                                                   const RoomId& room, const DeviceId& device,
                                                   Handler handler,
                                                   AnchorScope scope = AnchorScope::kRoom);
  ~DeviceBus() override;

  Result<void> Send(Upward message) override;
  void SayFarewell() override;

 private:
  struct Impl;

  explicit DeviceBus(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace waymark::session::wire
