// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "examples/simulator/world/city.h"

namespace waymark::simulator {

/// Which way round a block, seen from above.
enum class Turning { kCounterClockwise, kClockwise };

/// A closed path around a block at a constant distance from its house fronts, with round corners,
/// measured along from the middle of the block's south side. Immutable value.
class Route {
 public:
  /// `distance_m` > 0 is from the building line, `corner_radius_m` <= distance + half the block.
  Route(const Block& block, double distance_m, double corner_radius_m, Turning turning);

  double length_m() const { return length_m_; }
  Eigen::Vector2d At(double along_m) const;
  /// How far along one must go to be nearest to a place, to a decimetre.
  double FindNearest(const Eigen::Vector2d& place) const;

 private:
  Eigen::Vector2d centre_;
  Eigen::Vector2d straight_;  // lengths of the straight parts, east and north
  double radius_m_;
  double length_m_;
  Turning turning_;
};

}  // namespace waymark::simulator
