// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>

#include "session/state/events.h"
#include "session/wire/server_bus.h"

namespace waymark::session {

/// Tells devices what their owner alone may see, and remembers what each was told, so that nothing
/// stays on the bus of what is over or of whom has left. Thread-compatible.
class OwnerPublisher {
 public:
  explicit OwnerPublisher(wire::ServerBus& bus) : bus_(bus) {}

  void Do(const effect::SendOwn& effect, ServerTime now);
  void Do(const effect::SendOwnChange& effect, ServerTime now);
  /// It has left, or its line is about to be opened another way.
  void Forget(const DeviceId& device);
  /// Forgets what has been over for so long.
  void Tend(ServerTime now, std::chrono::nanoseconds memory_of_ends);

 private:
  struct Told {
    std::string owner;
    std::set<AnchorId> anchors;
    std::map<AnchorId, ServerTime> ended;  // since when
  };

  void Show(const DeviceId& device, const AnchorState& state);
  void End(const DeviceId& device, const AnchorId& anchor, ServerTime now);

  wire::ServerBus& bus_;
  std::map<DeviceId, Told> told_;
};

}  // namespace waymark::session
