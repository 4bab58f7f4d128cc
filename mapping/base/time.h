// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>

namespace waymark {

/// A named clock without a `now()`: whoever owns the hardware reads it and names the result.
template <typename Tag>
struct NamedClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<NamedClock>;
  static constexpr bool is_steady = false;
};

/// Instants of different clocks do not compare.
using SensorTime = NamedClock<struct SensorClockTag>::time_point;  ///< of one experience's recorder
using DeviceTime = NamedClock<struct DeviceClockTag>::time_point;  ///< of one phone
using ServerTime = NamedClock<struct ServerClockTag>::time_point;  ///< of the session

template <typename Instant>
constexpr Instant FromNanoseconds(std::int64_t nanoseconds) {
  return Instant{std::chrono::nanoseconds{nanoseconds}};
}

template <typename Instant>
constexpr std::int64_t ToNanoseconds(Instant instant) {
  return instant.time_since_epoch().count();
}

/// A duration as seconds, for numeric code.
template <typename Rep, typename Period>
constexpr double Seconds(std::chrono::duration<Rep, Period> duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace waymark
