// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "mapping/base/time.h"

namespace waymark {

/// The time since it was made or its last lap ended. Thread-compatible.
class Stopwatch {
 public:
  double ElapsedS() const { return Seconds(Clock::now() - begun_); }

  /// Ends a lap and begins the next; returns its seconds.
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

}  // namespace waymark
