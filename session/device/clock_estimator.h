// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "mapping/base/time.h"

namespace waymark::session {

/// The four instants of one exchange.
struct ClockExchange {
  DeviceTime device_sent;
  ServerTime server_received;
  ServerTime server_sent;
  DeviceTime device_received;
};

/// How far the session's clock is ahead of the device's, from exchanges with the server: the one
/// with the least delay in a window is taken, because queues only ever add delay. The error is at
/// most half the least delay; a path that is slower one way adds half the difference, which nobody
/// can observe. Thread-compatible.
class ClockEstimator {
 public:
  /// Exchanges with negative delay, of a clock that was set, are ignored.
  void Add(const ClockExchange& exchange);
  void Clear() { samples_.clear(); }

  /// Nothing before the first exchange.
  std::optional<ServerTime> ToSession(DeviceTime instant) const;
  std::optional<std::chrono::nanoseconds> Delay() const;

 private:
  struct Sample {
    std::chrono::nanoseconds delay;
    std::chrono::nanoseconds offset;
  };

  static constexpr std::size_t kWindow = 32;

  const Sample* Best() const;

  std::deque<Sample> samples_;  // oldest first
};

}  // namespace waymark::session
