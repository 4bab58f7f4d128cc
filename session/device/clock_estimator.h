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

/// How far this machine's steady clock is ahead of the clock that an application stamps its data
/// with, from the moments when data is handed over: the least difference counts, because delays
/// only add to it. So the error is the least delay from stamp to hand-over. Thread-compatible.
class StampClock {
 public:
  /// Data stamped so was handed over now.
  void Observe(DeviceTime stamp, DeviceTime steady_now);
  /// The stamp on the steady clock; as it is before the first observation.
  DeviceTime ToSteady(DeviceTime stamp) const;

 private:
  std::optional<std::chrono::nanoseconds> offset_;
};

}  // namespace waymark::session
