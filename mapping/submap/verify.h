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

/// What carried the cameras.
enum class Recorder {
  kUnknown,  ///< judged as a vehicle where it moves like one
  kVehicle,  ///< always judged as a vehicle
  kPerson,   ///< never
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
  double tolerated_share = 0.05;  ///< of images may be wrong

  // Creeping turns against the integrated gyroscope.
  double gyroscope_bias_sigma_rad_per_s = 0.002;  ///< per axis, constant within a submap
  double max_gyroscope_bias_rad_per_s = 0.0095;   ///< more than this is a bend, not a bias
  double max_rotation_drift_rad = 0.015;          ///< of an image, beside the bias, plus
  double max_gyroscope_scale_error = 0.005;       ///< times the angle turned

  // Motion of anything that carries cameras.
  double max_acceleration_mps2 = 10;
  double position_tolerance_m = 0.3;  ///< of a step, so that short steps may err

  // Motion of vehicles.
  Recorder recorder = Recorder::kUnknown;
  double min_vehicle_speed_mps = 3;           ///< median while moving; those on foot are slower
  double min_vehicle_share = 0.8;             ///< of the steps along the camera's usual direction
  double min_step_m = 1;                      ///< shorter ones have no direction
  double max_slip_rad = 0.12;                 ///< sideways motion, plus
  double max_lever_arm_m = 2.5;               ///< times the curvature: of the camera to rear axle
  double min_turning_radius_m = 4;            ///< while moving
  double max_yaw_rate_error_rad_per_s = 0.2;  ///< of the path's heading against the camera's turn

  // Shape against GNSS.
  double max_shape_error_m = 0.5;  ///< largest displacement by a drift of scale or heading, and
  double max_shape_sigmas = 4;     ///< times how well it is known: the larger is the bound

  Result<void> Validate() const;
};

/// Checks a reconstruction against everything that was measured beside the images. The verdict
/// names the first bound that is broken, or what was checked and with which figures; a check whose
/// sensor is absent is left out and the verdict says so. Every figure is in the evidence by name,
/// whatever the verdict. GNSS that contradicts a reconstruction which gyroscope and motion support
/// is no reason to discard it: the evidence says that GNSS is not to be followed.
/// Errors: InvalidArgument (options, lengths, indices).
/// Source: Platinsky et al. 2020, step 3.
Result<VerificationEvidence> VerifyReconstruction(const Reconstruction& reconstruction,
                                                  std::span<const VerificationImage> images,
                                                  std::span<const MeasuredRotation> rotations,
                                                  const VerificationOptions& options);

}  // namespace waymark::mapping
