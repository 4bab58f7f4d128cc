// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/upright_pose.h"

#include <Eigen/Geometry>

#include "mapping/estimation/upright_rig.h"

namespace waymark::mapping {

UprightPoseSolver::UprightPoseSolver(const SharedUp& up)
    : level_from_camera_(
          Eigen::Quaterniond::FromTwoVectors(up.in_camera, Eigen::Vector3d::UnitZ())),
      world_from_level_(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up.in_world)) {
}

// A rig of one camera: its rays meet.
void UprightPoseSolver::Solve(const std::array<Eigen::Vector3d, 2>& bearings_in_camera,
                              const std::array<Eigen::Vector3d, 2>& points_in_world,
                              std::vector<Rigid3>& poses) const {
  const auto ray = [&](const Eigen::Vector3d& bearing_in_camera) {
    return Ray{Eigen::Vector3d::Zero(), level_from_camera_ * bearing_in_camera};
  };
  const Eigen::Quaterniond level_from_world = world_from_level_.conjugate();
  const std::size_t known = poses.size();
  SolveUprightRig({ray(bearings_in_camera[0]), ray(bearings_in_camera[1])},
                  {level_from_world * points_in_world[0], level_from_world * points_in_world[1]},
                  poses);
  for (std::size_t i = known; i < poses.size(); ++i) {
    poses[i] = Rigid3(world_from_level_ * poses[i].rotation() * level_from_camera_,
                      world_from_level_ * poses[i].translation());
  }
}

}  // namespace waymark::mapping
