// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>

namespace waymark::session::wire {

/// How much somebody may say: a bucket that fills at a rate and holds two seconds of it.
/// Thread-compatible.
class Allowance {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit Allowance(double per_s, Time now = std::chrono::steady_clock::now())
      : per_s_(per_s), left_(2 * per_s), filled_(now) {}

  bool Take(double amount, Time now) {
    left_ = LeftAt(now);
    filled_ = now;
    if (left_ < amount) return false;
    left_ -= amount;
    return true;
  }
  bool IsFull(Time now) const { return LeftAt(now) >= 2 * per_s_; }

 private:
  double LeftAt(Time now) const {
    const double elapsed_s = std::chrono::duration<double>(now - filled_).count();
    return std::min(2 * per_s_, left_ + per_s_ * std::max(0.0, elapsed_s));
  }

  double per_s_;
  double left_;
  Time filled_;
};

}  // namespace waymark::session::wire
