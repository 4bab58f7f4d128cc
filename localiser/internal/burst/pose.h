// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>

#include "localiser/internal/image_matches.h"
#include "mapping/estimation/absolute_pose.h"

namespace waymark::localiser::internal {

struct BurstPoseOptions {
  double max_error_px = 6;
  int min_inliers = 15;  ///< of all images together
  int max_draws = 10000;
  double focal_sigma_share = 0;  ///< doubt about the cameras' focal lengths, one for all
  /// Doubt about odometry's metre against the submap's: 1 % is good odometry, and a map that only
  /// GNSS scales is no better.
  double scale_sigma_share = 0.02;
  /// Odometry's z. Units: of length 1
  Eigen::Vector3d up_in_submap = Eigen::Vector3d::UnitZ();
  std::uint64_t seed = 1;
};

/// In it "camera" is odometry's frame.
struct BurstPose : mapping::AbsolutePose {
  double odometry_scale = 1;  ///< on odometry's metre, as the matches have it
};

/// Estimates where odometry's frame is in a submap from the matches of several images at once: two
/// matches of any images and gravity are a sample of a robust loop; then refinement of all six
/// freedoms over all images. The covariance is that of independent errors. nullopt: no pose has
/// enough inliers.
std::optional<BurstPose> EstimateBurstPose(std::span<const BurstCamera> cameras,
                                           const ImageMatches& matches,
                                           const BurstPoseOptions& options);

/// The pose of one of the images, with its own covariance; odometry adds `drift_share` of the way
/// between the image and those that show the inliers.
mapping::AbsolutePose PoseOfImage(const mapping::AbsolutePose& submap_from_vo,
                                  std::span<const BurstCamera> cameras, const ImageMatches& matches,
                                  std::size_t image, double drift_share);

}  // namespace waymark::localiser::internal
