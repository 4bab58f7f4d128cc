// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

#include "mapping/base/allowance.h"

namespace waymark::session::dds {

/// How many lines others can make us write, so that a hostile peer fills no disk: forty at once and
/// then one in five seconds, which is 17,280 a day. Thread-safe.
class LogBudget {
 public:
  using Time = Allowance::Time;

  /// Whether a line may be written now, and how many were held back before it.
  std::optional<std::uint64_t> Admit(Time now) {
    const std::lock_guard lock(mutex_);
    if (lines_.Take(1, now)) return std::exchange(held_back_, 0);
    ++held_back_;
    return std::nullopt;
  }

 private:
  std::mutex mutex_;
  Allowance lines_{1.0 / 5, 40, Time{}};  // guarded by mutex_
  std::uint64_t held_back_ = 0;           // guarded by mutex_
};

}  // namespace waymark::session::dds
