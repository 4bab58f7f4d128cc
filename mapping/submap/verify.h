// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "mapping/base/result.h"
#include "mapping/base/time.h"
#include "mapping/sfm/reconstruction.h"
#include "mapping/submap/submap_model.h"

namespace waymark::mapping {

/// What the vehicle's sensors say about an image, in the order of the reconstruction's images.
struct VerificationImage {
  std::string sequence;  ///< images of one camera of one experience share it
  SensorTime time;
  std::optional<Eigen::Vector3d> up_in_camera;  ///< accelerometer, unit
  std::optional<Point<Submap>> gnss_in_submap;
  double gnss_sigma_m = 1;
  bool is_borrowed = false;
};

/// How a camera turned between two images, by the gyroscope.
struct MeasuredRotation {
  std::uint32_t from;
  std::uint32_t to;
  Eigen::Quaterniond to_from_from;  ///< camera at `to` from camera at `from`
  double seconds;                   ///< between them
};

struct VerificationOptions {
  int min_images = 3;                 ///< registered
  double min_registered_share = 0.2;  ///< of the images that are not borrowed
  int min_landmarks = 50;             ///< points in all
  double max_mean_reprojection_px = 2;
  double max_gyroscope_error_rad = 0.03;        ///< of a pair of images, plus
  double max_gyroscope_drift_rad_per_s = 0.02;  ///< times the time between them
  double max_gravity_error_rad = 0.1;           ///< median: single images are shaken by braking
  double max_speed_mps = 60;
  double max_gnss_sigmas = 5;     ///< median distance to GNSS; at least 10 m are allowed
  double tolerated_share = 0.05;  ///< of pairs may break the gyroscope or speed bound

  Result<void> Validate() const;
};

/// Checks a reconstruction against everything that was measured beside the images. The verdict
/// names the first bound that is broken, or what was checked and with which figures; a check whose
/// sensor is absent is left out and the verdict says so.
/// Errors: InvalidArgument (options, lengths, indices).
/// Source: Platinsky et al. 2020, step 3.
Result<VerificationEvidence> VerifyReconstruction(const Reconstruction& reconstruction,
                                                  std::span<const VerificationImage> images,
                                                  std::span<const MeasuredRotation> rotations,
                                                  const VerificationOptions& options);

}  // namespace waymark::mapping
