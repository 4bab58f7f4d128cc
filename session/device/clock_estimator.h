// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>

#include "mapping/base/time.h"

namespace waymark::session {

/// The clock that the session's is compared with: nobody sets it. It may stand still while the
/// device sleeps.
inline DeviceTime SteadyNow() {
  return DeviceTime(std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::steady_clock::now().time_since_epoch()));
}

/// The four instants of one exchange.
struct ClockExchange {
  DeviceTime device_sent;
  ServerTime server_received;
  ServerTime server_sent;
  DeviceTime device_received;
};

/// How far the session's clock is ahead of the device's, and how fast they drift apart, from
/// exchanges with the server. Each bounds the offset to within half its delay; queues only ever add
/// delay, so those of a minute are weighed by how little they have more than the least, and a line
/// is laid through them. The error is at most half the least delay; a path that is slower one way
/// adds half the difference, which nobody can observe. Thread-compatible.
class ClockEstimator {
 public:
  /// Exchanges with negative delay or one beyond 10 s, during which a clock was set, are ignored.
  /// One whose bounds contradict those before proves that a clock was set: then only it counts.
  void Add(const ClockExchange& exchange);
  void Clear();

  /// Nothing before the first exchange.
  std::optional<ServerTime> ToSession(DeviceTime instant) const;
  /// The least of the last minute.
  std::optional<std::chrono::nanoseconds> Delay() const;
  /// Seconds that the session's clock gains on the device's in a second; 0 at first.
  double Drift() const { return drift_; }
  /// How often a clock was found to have been set.
  int jumps() const { return jumps_; }

 private:
  struct Sample {
    DeviceTime time;  ///< the middle of the exchange
    std::chrono::nanoseconds delay;
    std::chrono::nanoseconds offset;
  };

  bool Contradicts(const Sample& sample) const;
  std::chrono::nanoseconds OffsetAt(DeviceTime instant) const;
  void Fit();

  std::deque<Sample> samples_;  // oldest first
  std::chrono::nanoseconds least_delay_{};
  // offset = offset_ + drift_ * (time - time_)
  DeviceTime time_;
  std::chrono::nanoseconds offset_{};
  double drift_ = 0;
  int jumps_ = 0;
};

/// How far this machine's steady clock is ahead of the clock that an application stamps its data
/// with, from the moments when data is handed over: the least difference counts, because delays
/// only add to it. So the error is the least delay from stamp to hand-over. Thread-compatible.
class StampClock {
 public:
  /// Data stamped so was handed over now. Returns by how much the stamps' clock was set since the
  /// data before, if it was.
  std::optional<std::chrono::nanoseconds> Observe(DeviceTime stamp, DeviceTime steady_now);
  /// The stamp on the steady clock; as it is before the first observation.
  DeviceTime ToSteady(DeviceTime stamp) const;

 private:
  std::optional<std::chrono::nanoseconds> offset_;
};

}  // namespace waymark::session
