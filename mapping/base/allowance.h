// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>

namespace waymark {

/// How much somebody may have: a bucket that fills at a rate, is full at first, and holds so much.
/// Thread-compatible.
class Allowance {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Holds two seconds of its rate.
  explicit Allowance(double per_s, Time now = std::chrono::steady_clock::now())
      : Allowance(per_s, 2 * per_s, now) {}
  Allowance(double per_s, double holds, Time now)
      : per_s_(per_s), holds_(holds), left_(holds), filled_(now) {}

  bool Take(double amount, Time now) {
    left_ = LeftAt(now);
    filled_ = std::max(filled_, now);
    if (left_ < amount) return false;
    left_ -= amount;
    return true;
  }
  bool IsFull(Time now) const { return LeftAt(now) >= holds_; }

 private:
  double LeftAt(Time now) const {
    const double elapsed_s = std::chrono::duration<double>(now - filled_).count();
    return std::min(holds_, left_ + per_s_ * std::max(0.0, elapsed_s));
  }

  double per_s_;
  double holds_;
  double left_;
  Time filled_;
};

}  // namespace waymark
