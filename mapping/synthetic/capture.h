// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "mapping/features/features.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"
#include "mapping/sfm/incremental.h"
#include "mapping/synthetic/world.h"

namespace waymark::mapping {

/// How a made-up camera errs.
struct CaptureOptions {
  double pixel_sigma_px = 0;
  double outlier_share = 0;  ///< of each pair's matches: joined to a wrong feature
  double max_range_m = 60;
  int max_features = 2000;                       ///< nearest points kept
  std::optional<double> gnss_sigma_m = {};       ///< absent: no GNSS
  double gnss_outlier_share = 0;                 ///< of the fixes: tens of metres off
  std::optional<double> gravity_sigma_rad = {};  ///< absent: no accelerometer
  /// Rolling shutter: from the first row to the last; needs `pose_at`.
  double readout_s = 0;
  /// world_from_camera of an image's camera so many seconds after its middle row.
  std::function<Rigid3(std::size_t image, double seconds)> pose_at = {};
  std::uint64_t seed = 1;
};

/// What one camera saw on a walk, with the truth.
struct Capture {
  CameraModel camera;
  std::vector<Rigid3> world_from_camera;
  std::vector<std::vector<Keypoint>> keypoints = {};      ///< per image
  std::vector<std::vector<std::uint32_t>> point_of = {};  ///< per image and keypoint: World::points
  std::vector<std::optional<Eigen::Vector3d>> gnss_in_world = {};
  std::vector<std::optional<Eigen::Vector3d>> up_in_camera = {};
  double gnss_sigma_m = 1;

  /// As input of structure from motion; borrows the keypoints.
  std::vector<SfmImage> Images() const;
};

Capture CaptureWalk(const World& world, const CameraModel& camera, std::span<const Rigid3> walk,
                    const CaptureOptions& options);

/// Matches of all pairs of images that share at least `min_shared` points.
std::vector<PairMatches> MatchCapture(const Capture& capture, std::size_t min_shared,
                                      const CaptureOptions& options);

}  // namespace waymark::mapping
