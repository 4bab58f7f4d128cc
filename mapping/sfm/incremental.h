// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "mapping/base/parallel.h"
#include "mapping/base/result.h"
#include "mapping/features/features.h"
#include "mapping/matching/candidate_pairs.h"
#include "mapping/matching/descriptor_matching.h"
#include "mapping/sfm/reconstruction.h"

namespace waymark::mapping {

/// A camera of the input; its intrinsics are refined unless held.
struct SfmCamera {
  CameraModel model;
  bool has_known_focal = true;
  bool refine = true;
  double readout_s = 0;  ///< of a rolling shutter: from the first row to the last; 0: global
};

/// An image of the input. The submap frame is ENU at the submap's origin, so priors are in it.
struct SfmImage {
  std::uint32_t camera = 0;  ///< index into the cameras
  std::span<const Keypoint> keypoints = {};
  std::optional<Point<Submap>> gnss_in_submap = {};  ///< prior of the camera centre
  double gnss_sigma_m = 1;
  /// The direction "up" seen by the accelerometer in camera axes, unit length.
  std::optional<Eigen::Vector3d> up_in_camera = {};
  std::uint32_t group = 0;  ///< images of one experience share it: verification and pairing
  std::optional<double> time_s = {};  ///< of the middle row; for rolling shutters
};

/// Descriptor matches of one candidate pair, before geometric verification.
struct PairMatches {
  ImagePair pair;
  std::vector<FeatureMatch> matches;
};

/// Two cameras of one rig: when `image` was taken, another camera was on its way from `before` to
/// `after`, two images of its own, and stood at `offset_in_camera`.
struct RigLink {
  std::uint32_t image;
  std::uint32_t before;
  std::uint32_t after;
  double share;                      ///< of the time from `before` to `after`, [0, 1]
  Eigen::Vector3d offset_in_camera;  ///< in the frame of `image`
  double sigma_m = 0.01;             ///< of the mounting and of the straight line between the two
};

struct SfmOptions {
  double max_epipolar_error_px = 4;            ///< two-view inliers
  int min_pair_inliers = 15;                   ///< a pair below is dropped
  double max_reprojection_px = 4;              ///< observations above are removed from tracks
  double min_triangulation_angle_rad = 0.026;  ///< 1.5 degrees
  bool refine_intrinsics = true;
  double gravity_sigma_rad = 0.02;  ///< of one accelerometer direction
  std::uint64_t seed = 1;
  Parallelism parallelism;

  Result<void> Validate() const;
};

/// Called now and then with what is being done and the share done, [0, 1].
using SfmProgress = std::function<void(std::string_view stage, double share)>;

/// Reconstructs poses and points by cost (1): verified pairs, tracks, an initial pair, then images
/// one after the other with bundle adjustment, GNSS priors, gravity and rig links as robust terms.
/// Images that cannot join are reported with the reason, in `Reconstruction::images`.
/// Errors: InvalidArgument (indices, options); NotFound when not even two images overlap.
/// Source: Platinsky et al. 2020, eq. (1); Schoenberger & Frahm, "Structure-from-motion revisited",
/// CVPR 2016, for the order of registration, retriangulation and filtering.
Result<Reconstruction> ReconstructIncrementally(std::span<const SfmCamera> cameras,
                                                std::span<const SfmImage> images,
                                                std::span<const PairMatches> matches,
                                                const SfmOptions& options,
                                                const SfmProgress& progress = {},
                                                std::span<const RigLink> rig_links = {});

}  // namespace waymark::mapping
