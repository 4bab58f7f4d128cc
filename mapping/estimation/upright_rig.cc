// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/upright_rig.h"

#include <Eigen/Geometry>

#include <cmath>

namespace waymark::mapping {

// With a turn R about the vertical, origins c, bearings b and distances s in the rig:
//   R^T (X2 - X1) = (c2 + s2 b2) - (c1 + s1 b1).
// The vertical component is linear in the distances, so they lie on a line; the horizontal length
// is known, which is a quadratic equation on that line.
void SolveUprightRig(const std::array<Ray, 2>& rays_in_rig,
                     const std::array<Eigen::Vector3d, 2>& points_in_world,
                     std::vector<Rigid3>& world_from_rig) {
  const auto& [first, second] = rays_in_rig;
  const Eigen::Vector3d offset = points_in_world[1] - points_in_world[0];
  const Eigen::Vector3d between = second.origin - first.origin;
  constexpr double kLevel = 1e-6;  // sine of a bearing's height that tells nothing any more
  const Eigen::Vector2d normal(-first.bearing.z(), second.bearing.z());
  const double squared = normal.squaredNorm();
  const double flat = offset.head<2>().squaredNorm();
  if (!(squared > kLevel * kLevel) || !(flat > 0)) return;
  // (s1, s2) = foot + t * along
  const Eigen::Vector2d foot = normal * ((offset.z() - between.z()) / squared);
  const Eigen::Vector2d along(normal.y(), -normal.x());
  const Eigen::Vector2d at_foot =
      between.head<2>() + foot.y() * second.bearing.head<2>() - foot.x() * first.bearing.head<2>();
  const Eigen::Vector2d per_step =
      along.y() * second.bearing.head<2>() - along.x() * first.bearing.head<2>();
  const double a = per_step.squaredNorm();
  const double half_b = per_step.dot(at_foot);
  const double c = at_foot.squaredNorm() - flat;
  const double discriminant = half_b * half_b - a * c;
  if (!(a > 0) || !(discriminant >= 0)) return;
  const double root = std::sqrt(discriminant);
  for (const double t : {(-half_b - root) / a, (-half_b + root) / a}) {
    const Eigen::Vector2d distances = foot + t * along;
    if (!(distances.minCoeff() > 0) || !distances.allFinite()) continue;
    const Eigen::Vector2d seen = at_foot + t * per_step;
    const double turn_rad = std::atan2(offset.y(), offset.x()) - std::atan2(seen.y(), seen.x());
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()));
    const Eigen::Vector3d seen_point = first.origin + distances.x() * first.bearing;
    world_from_rig.emplace_back(turn, points_in_world[0] - turn * seen_point);
  }
}

}  // namespace waymark::mapping
