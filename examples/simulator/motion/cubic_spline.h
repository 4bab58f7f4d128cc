// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "mapping/base/check.h"

namespace waymark::simulator {

/// A uniform cubic B-spline: twice continuously differentiable, so that accelerations are.
/// Immutable value.
template <int kSize>
class CubicSpline {
 public:
  using Vector = Eigen::Matrix<double, kSize, 1>;

  /// Value and derivatives by time.
  struct Sample {
    Vector value;
    Vector velocity;
    Vector acceleration;
  };

  /// The curve passes near `controls[i]` at time `start_s + i * interval_s`; at least four of them.
  CubicSpline(std::vector<Vector> controls, double interval_s, double start_s)
      : controls_(std::move(controls)), interval_s_(interval_s), start_s_(start_s) {
    CHECK(controls_.size() >= 4 && interval_s > 0, "{} controls every {} s", controls_.size(),
          interval_s);
  }

  /// Where the curve is defined: [first, last].
  double first_s() const { return start_s_ + interval_s_; }
  double last_s() const {
    return start_s_ + interval_s_ * static_cast<double>(controls_.size() - 2);
  }

  /// At the nearest time where it is defined.
  Sample At(double time_s) const {
    const double position = (std::clamp(time_s, first_s(), last_s()) - start_s_) / interval_s_;
    const double last_node = static_cast<double>(controls_.size() - 3);
    const double node = std::clamp(std::floor(position), 1.0, last_node);
    const double t = position - node;
    const Vector* c = &controls_[static_cast<std::size_t>(node) - 1];
    const double s = 1 - t;
    return {
        (s * s * s * c[0] + (3 * t * t * t - 6 * t * t + 4) * c[1] +
         (3 * s * s * s - 6 * s * s + 4) * c[2] + t * t * t * c[3]) /
            6,
        (-s * s * c[0] + (3 * t * t - 4 * t) * c[1] + (4 * s - 3 * s * s) * c[2] + t * t * c[3]) /
            (2 * interval_s_),
        (s * c[0] + (3 * t - 2) * c[1] + (3 * s - 2) * c[2] + t * c[3]) /
            (interval_s_ * interval_s_)};
  }

 private:
  std::vector<Vector> controls_;
  double interval_s_;
  double start_s_;
};

}  // namespace waymark::simulator
