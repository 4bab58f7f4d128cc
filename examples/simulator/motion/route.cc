// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/motion/route.h"

#include <array>
#include <cmath>
#include <numbers>

#include "mapping/base/check.h"

namespace waymark::simulator {

using Eigen::Vector2d;

Route::Route(const Block& block, double distance_m, double corner_radius_m, Turning turning)
    : centre_((block.low + block.high) / 2),
      straight_(block.high - block.low + Vector2d::Constant(2 * (distance_m - corner_radius_m))),
      radius_m_(corner_radius_m),
      length_m_(2 * straight_.sum() + 2 * std::numbers::pi * corner_radius_m),
      turning_(turning) {
  CHECK(straight_.minCoeff() >= 0, "corner radius {} m does not fit", corner_radius_m);
}

Vector2d Route::At(double along_m) const {
  double rest = std::fmod(along_m, length_m_);
  if (rest < 0) rest += length_m_;
  if (turning_ == Turning::kClockwise) rest = length_m_ - rest;
  rest = std::fmod(rest + straight_.x() / 2, length_m_);  // from the south side's west end
  const double arc = std::numbers::pi / 2 * radius_m_;
  const std::array<double, 4> sides{straight_.x(), straight_.y(), straight_.x(), straight_.y()};
  Vector2d corner = centre_ - straight_ / 2;  // centre of the arc before the present side
  Vector2d direction(1, 0);
  for (const double side : sides) {
    const Vector2d outwards(direction.y(), -direction.x());
    if (rest < side) return corner + rest * direction + radius_m_ * outwards;
    rest -= side;
    corner += side * direction;
    if (rest < arc) {
      const double angle = rest / radius_m_;
      return corner + radius_m_ * (std::cos(angle) * outwards + std::sin(angle) * direction);
    }
    rest -= arc;
    direction = Vector2d(-direction.y(), direction.x());
  }
  return corner + radius_m_ * Vector2d(direction.y(), -direction.x());
}

double Route::FindNearest(const Vector2d& place) const {
  double best = 0;
  double best_distance = (At(0) - place).norm();
  for (double along = 0.1; along < length_m_; along += 0.1) {
    const double distance = (At(along) - place).norm();
    if (distance < best_distance) {
      best = along;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace waymark::simulator
