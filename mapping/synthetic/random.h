// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace waymark::mapping::internal {

/// Random numbers that are the same on every standard library, unlike std::normal_distribution.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// [0, 1)
  double Unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Unit(); }
  std::size_t Below(std::size_t bound) {
    return static_cast<std::size_t>(Unit() * static_cast<double>(bound));
  }
  double Normal(double sigma) {
    return sigma * std::sqrt(-2 * std::log(1 - Unit())) * std::cos(2 * std::numbers::pi * Unit());
  }
  Eigen::Vector3d NormalVector(double sigma) {
    const double x = Normal(sigma);
    const double y = Normal(sigma);
    return {x, y, Normal(sigma)};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace waymark::mapping::internal
