// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <utility>

#include "session/state/events.h"
#include "session/wire/server_bus.h"

namespace waymark::session {

/// Tells devices that speak for themselves of the anchors in their areas, and lets nothing stay on
/// the bus of what is over. Thread-compatible.
class AreaPublisher {
 public:
  explicit AreaPublisher(wire::ServerBus& bus) : bus_(bus) {}

  void Do(const effect::TellArea& effect, ServerTime now);
  /// It has left: its return begins with nothing.
  void Forget(const DeviceId& device);
  /// Forgets what has been over for so long.
  void Tend(ServerTime now, std::chrono::nanoseconds memory_of_ends);

 private:
  wire::ServerBus& bus_;
  std::map<std::pair<DeviceId, AnchorId>, ServerTime> ended_;  // since when
};

}  // namespace waymark::session
