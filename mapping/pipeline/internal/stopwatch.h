// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "mapping/base/time.h"

namespace waymark::mapping {

/// Seconds since it was made or last asked. Thread-compatible.
class Stopwatch {
 public:
  double Lap() {
    const auto now = Clock::now();
    const double seconds = Seconds(now - begun_);
    begun_ = now;
    return seconds;
  }

 private:
  using Clock = std::chrono::steady_clock;

  Clock::time_point begun_ = Clock::now();
};

}  // namespace waymark::mapping
