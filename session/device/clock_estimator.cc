// SPDX-License-Identifier: Apache-2.0
#include "session/device/clock_estimator.h"

#include <algorithm>

namespace waymark::session {

void ClockEstimator::Add(const ClockExchange& exchange) {
  const auto up =
      exchange.server_received.time_since_epoch() - exchange.device_sent.time_since_epoch();
  const auto down =
      exchange.server_sent.time_since_epoch() - exchange.device_received.time_since_epoch();
  const std::chrono::nanoseconds delay = up - down;
  if (delay < std::chrono::nanoseconds::zero()) return;
  samples_.push_back({delay, down + (up - down) / 2});
  if (samples_.size() > kWindow) samples_.pop_front();
}

const ClockEstimator::Sample* ClockEstimator::Best() const {
  const auto best =
      std::min_element(samples_.begin(), samples_.end(),
                       [](const Sample& a, const Sample& b) { return a.delay < b.delay; });
  return best == samples_.end() ? nullptr : &*best;
}

std::optional<ServerTime> ClockEstimator::ToSession(DeviceTime instant) const {
  const Sample* const best = Best();
  if (best == nullptr) return std::nullopt;
  return ServerTime(instant.time_since_epoch() + best->offset);
}

void StampClock::Observe(DeviceTime stamp, DeviceTime steady_now) {
  constexpr std::chrono::seconds kJump{2};  // more is no delay: the stamps' clock was set or paused
  const std::chrono::nanoseconds difference = steady_now - stamp;
  if (!offset_ || difference < *offset_ || difference - *offset_ > kJump) offset_ = difference;
}

DeviceTime StampClock::ToSteady(DeviceTime stamp) const {
  return stamp + offset_.value_or(std::chrono::nanoseconds::zero());
}

std::optional<std::chrono::nanoseconds> ClockEstimator::Delay() const {
  const Sample* const best = Best();
  if (best == nullptr) return std::nullopt;
  return best->delay;
}

}  // namespace waymark::session
