// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>

#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

struct PoseRefinementOptions {
  double huber_px = 1;  ///< residuals above it count linearly
  int max_iterations = 15;
  double focal_sigma_share = 0;  ///< of the stated focal length, which is refined too; 0: exact
  double pixel_sigma_px = 1;     ///< weighs pixels against the stated focal length
};

struct RefinedPose {
  Rigid3 world_from_camera;
  double focal_factor = 1;                  ///< on the camera's focal length
  Eigen::Matrix<double, 6, 6> information;  ///< of Perturb's delta for a pixel sigma of 1
  double weighted_squares = 0;              ///< sum of weight * squared residual, px^2
};

/// Refines a pose over the chosen matches: Levenberg-Marquardt on Huber reprojection error with
/// analytic derivatives; of the focal length too when it is in doubt. nullopt: the matches do not
/// determine a pose, or lie behind the camera. Frames: points in the world of the pose
std::optional<RefinedPose> RefinePose(const CameraModel& camera,
                                      std::span<const Eigen::Vector2d> pixels_px,
                                      std::span<const Eigen::Vector3d> points_in_world,
                                      std::span<const std::uint32_t> chosen,
                                      const Rigid3& world_from_camera,
                                      const PoseRefinementOptions& options);

}  // namespace waymark::mapping
