// SPDX-License-Identifier: Apache-2.0
#include "session/device/clock_estimator.h"

#include <algorithm>

namespace waymark::session {
namespace {

using std::chrono::nanoseconds;

constexpr std::chrono::seconds kMemory{60};
constexpr std::size_t kMaxSamples = 256;
constexpr std::chrono::seconds kMostDelay{10};  // with more, the clock was set meanwhile
// Phones' crystals are good to a few tens of ppm, and warm up slowly.
constexpr double kDriftSigma = 50e-6;
constexpr double kMostDrift = 500e-6;
constexpr double kSigma_s = 0.5e-3;             // of an exchange with the least delay
constexpr std::chrono::milliseconds kSlack{1};  // of stamps: a thread that was not woken at once

double InSeconds(nanoseconds duration) { return Seconds(duration); }

}  // namespace

void ClockEstimator::Add(const ClockExchange& exchange) {
  const nanoseconds up =
      exchange.server_received.time_since_epoch() - exchange.device_sent.time_since_epoch();
  const nanoseconds down =
      exchange.server_sent.time_since_epoch() - exchange.device_received.time_since_epoch();
  const Sample sample{
      .time = exchange.device_sent + (exchange.device_received - exchange.device_sent) / 2,
      .delay = up - down,
      .offset = down + (up - down) / 2};
  if (sample.delay < nanoseconds::zero() || sample.delay > kMostDelay) return;
  if (Contradicts(sample)) {
    ++jumps_;
    samples_.clear();
  }
  samples_.push_back(sample);
  while (samples_.size() > kMaxSamples || sample.time - samples_.front().time > kMemory) {
    samples_.pop_front();
  }
  Fit();
}

void ClockEstimator::Clear() {
  samples_.clear();
  drift_ = 0;
}

bool ClockEstimator::Contradicts(const Sample& sample) const {
  return std::any_of(samples_.begin(), samples_.end(), [&](const Sample& earlier) {
    const nanoseconds age =
        sample.time > earlier.time ? sample.time - earlier.time : earlier.time - sample.time;
    const double allowed_s = 0.5 * InSeconds(sample.delay + earlier.delay) +
                             kMostDrift * std::min(InSeconds(age), InSeconds(kMemory)) +
                             InSeconds(kSlack);
    return std::abs(InSeconds(sample.offset - earlier.offset)) > allowed_s;
  });
}

/// Weighted least squares; the drift is believed to be 0 to within its sigma.
void ClockEstimator::Fit() {
  time_ = samples_.back().time;
  least_delay_ =
      std::min_element(samples_.begin(), samples_.end(), [](const auto& a, const auto& b) {
        return a.delay < b.delay;
      })->delay;
  // Relative to one offset, so that doubles keep nanoseconds.
  const nanoseconds origin = samples_.back().offset;
  double w = 0, wt = 0, wtt = 1 / (kDriftSigma * kDriftSigma), wy = 0, wty = 0;
  for (const Sample& sample : samples_) {
    // What it has more may lie anywhere on the two ways: evenly within half of it.
    const double excess_s = InSeconds(sample.delay - least_delay_);
    const double weight = 1 / (kSigma_s * kSigma_s + excess_s * excess_s / 12);
    const double t = InSeconds(sample.time - time_), y = InSeconds(sample.offset - origin);
    w += weight;
    wt += weight * t;
    wtt += weight * t * t;
    wy += weight * y;
    wty += weight * t * y;
  }
  drift_ = (w * wty - wt * wy) / (w * wtt - wt * wt);
  const double offset_s = (wy - drift_ * wt) / w;
  offset_ = origin + std::chrono::round<nanoseconds>(std::chrono::duration<double>(offset_s));
}

nanoseconds ClockEstimator::OffsetAt(DeviceTime instant) const {
  // Far from the exchanges the line says nothing.
  const double away_s =
      std::clamp(InSeconds(instant - time_), -InSeconds(kMemory), InSeconds(kMemory));
  return offset_ + std::chrono::round<nanoseconds>(std::chrono::duration<double>(drift_ * away_s));
}

std::optional<ServerTime> ClockEstimator::ToSession(DeviceTime instant) const {
  if (samples_.empty()) return std::nullopt;
  return ServerTime(instant.time_since_epoch() + OffsetAt(instant));
}

std::optional<nanoseconds> ClockEstimator::Delay() const {
  if (samples_.empty()) return std::nullopt;
  return least_delay_;
}

std::optional<nanoseconds> StampClock::Observe(DeviceTime stamp, DeviceTime steady_now) {
  constexpr std::chrono::seconds kJump{2};  // more is no delay: the stamps' clock was set or paused
  const nanoseconds difference = steady_now - stamp;
  const std::optional<nanoseconds> before = offset_;
  if (!before || difference < *before || difference - *before > kJump) offset_ = difference;
  if (!before || std::chrono::abs(difference - *before) <= kJump) return std::nullopt;
  return *before - difference;
}

DeviceTime StampClock::ToSteady(DeviceTime stamp) const {
  return stamp + offset_.value_or(nanoseconds::zero());
}

}  // namespace waymark::session
