// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <array>
#include <optional>
#include <vector>

#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

/// The direction that is up, as a camera and the world know it. Units: both of length 1
struct SharedUp {
  Eigen::Vector3d in_camera;
  Eigen::Vector3d in_world;
};

/// Solves for the four freedoms that gravity leaves to a camera, heading and place, from two
/// points. Thread-safe. Source: upright_rig.h, with one camera.
class UprightPoseSolver {
 public:
  explicit UprightPoseSolver(const SharedUp& up);

  /// Appends the at most two poses, world_from_camera, that see both points along their bearings
  /// and in front. None when the points lie above each other or at the camera's height.
  /// Units: bearings of length 1
  void Solve(const std::array<Eigen::Vector3d, 2>& bearings_in_camera,
             const std::array<Eigen::Vector3d, 2>& points_in_world,
             std::vector<Rigid3>& poses) const;

 private:
  Eigen::Quaterniond level_from_camera_;  // z is up
  Eigen::Quaterniond world_from_level_;
};

}  // namespace waymark::mapping
