// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/estimation/upright_pose.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

struct AbsolutePoseOptions {
  double max_error_px = 4;     ///< reprojection error of an inlier, at the camera's full size
  int min_inliers = 12;        ///< fewer is "no pose"
  double confidence = 0.9999;  ///< that an all-inlier sample was drawn, (0, 1)
  int max_iterations = 10000;
  double focal_sigma_share = 0;  ///< doubt about the camera's focal length, relative; 0: exact
  /// Which way is up, good to a few degrees: then two matches make a sample instead of three.
  std::optional<SharedUp> up = std::nullopt;
  std::uint64_t seed = 1;

  Result<void> Validate() const;
};

/// A pose with its evidence. "World" is whatever frame the points are in.
struct AbsolutePose {
  Rigid3 world_from_camera;
  double focal_factor = 1;                 ///< on the camera's focal length: 1 when it is exact
  std::vector<std::uint32_t> inliers;      ///< indices of the correspondences, ascending
  double rms_px = 0;                       ///< over the inliers
  Eigen::Matrix<double, 6, 6> covariance;  ///< of Perturb's delta in the world frame
  int iterations = 0;
};

/// Estimates where a camera stood from 2D-3D matches: P3P, or two points and gravity, inside a
/// locally optimised robust loop, then robust refinement over all inliers, of the focal length too
/// where it is in doubt and the matches contradict it. nullopt: no pose has enough inliers.
/// Frames:  points and result in one world frame
/// Shapes:  pixels_px and points_in_world have equal length; `quality` too, or is empty: higher
///          is tried first (progressive sampling)
/// Errors:  InvalidArgument if lengths differ
/// Source:  OpenGV's P3P (Kneip, CVPR 2011) as minimal solver
Result<std::optional<AbsolutePose>> EstimateAbsolutePose(
    const CameraModel& camera, std::span<const Eigen::Vector2d> pixels_px,
    std::span<const Eigen::Vector3d> points_in_world, std::span<const double> quality,
    const AbsolutePoseOptions& options);

}  // namespace waymark::mapping
