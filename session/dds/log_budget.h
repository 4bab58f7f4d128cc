// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace waymark::session::dds {

/// How many lines others can make us write, so that a hostile peer fills no disk: forty at once and
/// then one in five seconds, which is 17,280 a day. Thread-safe.
class LogBudget {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Whether a line may be written now, and how many were held back before it.
  std::optional<std::uint64_t> Admit(Time now) {
    const std::lock_guard lock(mutex_);
    if (full_again_ - now > (kBurst - 1) * kInterval) {
      ++held_back_;
      return std::nullopt;
    }
    full_again_ = std::max(full_again_, now) + kInterval;
    return std::exchange(held_back_, 0);
  }

 private:
  static constexpr int kBurst = 40;
  static constexpr std::chrono::seconds kInterval{5};

  std::mutex mutex_;
  Time full_again_{};            // guarded by mutex_
  std::uint64_t held_back_ = 0;  // guarded by mutex_
};

}  // namespace waymark::session::dds
