// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <span>

namespace waymark::mapping {

struct Circle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0;

  /// With a tolerance of a nanometre, so that the circle contains the points it was made from.
  bool Contains(const Eigen::Vector2d& point) const {
    return (point - centre).norm() <= radius + 1e-9;
  }
};

/// The smallest circle around the points; radius 0 at the origin when there are none.
/// Source: Welzl, "Smallest enclosing disks", 1991, in its iterative form.
Circle ComputeEnclosingCircle(std::span<const Eigen::Vector2d> points);

}  // namespace waymark::mapping
