// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <vector>

#include "session/socket/channel.h"
#include "session/state/messages.h"

namespace waymark::bench {

/// What one phone of a crowd has heard while it was counted.
struct Heard {
  std::set<std::uint32_t> ticks;    ///< of which a pose batch came
  std::vector<float> latencies_ms;  ///< from one phone's report to another's hearing of it
  std::uint64_t bytes = 0;
};

/// Many phones in one process, which walk, report their poses and listen, each on a connection of
/// its own to a gateway.
class Crowd {
 public:
  /// Phones stand in rooms of `per_room`.
  Crowd(std::uint16_t gateway_port, int phones, int per_room);
  ~Crowd();

  /// Waits until all are welcome; returns how long it took, or a negative number when that was more
  /// than a minute.
  double JoinAll();
  /// All report poses at this rate for so long; what is heard meanwhile is kept.
  std::vector<Heard> Walk(double hz, double seconds);

 private:
  class Phone;

  void TellAll(double hz, double seconds);

  std::vector<std::shared_ptr<Phone>> phones_;
  session::socket::SocketLoop loop_{1};
};

}  // namespace waymark::bench
