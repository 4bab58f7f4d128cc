// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/upright_pose.h"

#include <Eigen/Geometry>

#include <cmath>

namespace waymark::mapping {

UprightPoseSolver::UprightPoseSolver(const SharedUp& up)
    : level_from_camera_(
          Eigen::Quaterniond::FromTwoVectors(up.in_camera, Eigen::Vector3d::UnitZ())),
      world_from_level_(
          Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up.in_world)) {}

// With a turn R about the vertical, bearings b and distances s in the level frame:
//   R^T (X2 - X1) = s2 b2 - s1 b1.
// The vertical component is linear in the distances, so they lie on a line; the horizontal length is
// known, which is a quadratic equation on that line.
void UprightPoseSolver::Solve(const std::array<Eigen::Vector3d, 2>& bearings_in_camera,
                              const std::array<Eigen::Vector3d, 2>& points_in_world,
                              std::vector<Rigid3>& poses) const {
  const Eigen::Vector3d b1 = level_from_camera_ * bearings_in_camera[0];
  const Eigen::Vector3d b2 = level_from_camera_ * bearings_in_camera[1];
  const Eigen::Vector3d x1 = world_from_level_.conjugate() * points_in_world[0];
  const Eigen::Vector3d offset = world_from_level_.conjugate() * points_in_world[1] - x1;
  constexpr double kLevel = 1e-6;  // sine of a bearing's height that tells nothing any more
  const Eigen::Vector2d normal(-b1.z(), b2.z());
  const double squared = normal.squaredNorm();
  const double flat = offset.head<2>().squaredNorm();
  if (!(squared > kLevel * kLevel) || !(flat > 0)) return;
  // (s1, s2) = foot + t * along
  const Eigen::Vector2d foot = normal * (offset.z() / squared);
  const Eigen::Vector2d along(normal.y(), -normal.x());
  const Eigen::Vector2d at_foot = foot.y() * b2.head<2>() - foot.x() * b1.head<2>();
  const Eigen::Vector2d per_step = along.y() * b2.head<2>() - along.x() * b1.head<2>();
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
    const double turn_rad =
        std::atan2(offset.y(), offset.x()) - std::atan2(seen.y(), seen.x());
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()));
    poses.emplace_back(world_from_level_ * turn * level_from_camera_,
                       world_from_level_ * (x1 - turn * (distances.x() * b1)));
  }
}

}  // namespace waymark::mapping
