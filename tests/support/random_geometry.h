// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "mapping/geometry/rigid3.h"
#include "mapping/geometry/sim3.h"

namespace waymark::support {

/// Seeded random vectors, rotations and motions for law tests.
class RandomGeometry {
 public:
  explicit RandomGeometry(std::uint64_t seed) : engine_(seed) {}

  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  double Normal(double sigma) { return std::normal_distribution<double>(0, sigma)(engine_); }
  Eigen::Vector3d Vector(double half_width) {
    return {Uniform(-half_width, half_width), Uniform(-half_width, half_width),
            Uniform(-half_width, half_width)};
  }
  Eigen::Quaterniond Rotation() {
    return Eigen::Quaterniond(Normal(1), Normal(1), Normal(1), Normal(1)).normalized();
  }
  Rigid3 Rigid() { return {Rotation(), Vector(10)}; }
  Sim3 Similarity() { return {std::exp(Uniform(-1, 1)), Rotation(), Vector(10)}; }

 private:
  std::mt19937_64 engine_;
};

MATCHER_P(Near, expected, "is near the expected transform") {
  const double translation_error = (arg.translation() - expected.translation()).norm();
  const double rotation_error = AngleBetween(arg.rotation(), expected.rotation()).radians();
  *result_listener << "off by " << translation_error << " and " << rotation_error << " rad";
  return translation_error < 1e-9 && rotation_error < 1e-9;
}

}  // namespace waymark::support
