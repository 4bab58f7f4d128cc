// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/geometry/rigid3.h"
#include "mapping/geometry/sim3.h"

namespace waymark::mapping {

/// What is known of one camera of a reconstruction whose frame ("model") is arbitrary.
struct GeoSample {
  Rigid3 model_from_camera;
  std::optional<Eigen::Vector3d> position_in_enu;  ///< GNSS
  double position_sigma_m = 1;
  std::optional<Eigen::Vector3d> up_in_camera;  ///< accelerometer
};

struct GeoAlignmentOptions {
  double gravity_sigma_rad = 0.02;
  double level_sigma_rad = 0.2;   ///< of "camera x axes are horizontal", used without gravity
  double max_error_sigmas = 3;    ///< of a position that still counts
  double max_scale_error = 0.25;  ///< expected relative error above which positions say nothing
  std::uint64_t seed = 1;
};

struct GeoAlignment {
  Sim3 enu_from_model;
  std::vector<std::uint32_t> inliers;  ///< samples whose position fits, ascending
  bool is_straight = false;  ///< positions lie on a line: roll about it came from up directions
};

/// The direction "up" in the model: the robust mean of the accelerometers', else the one that makes
/// the cameras' x axes horizontal, with their y axes pointing down on average.
Eigen::Vector3d EstimateUp(std::span<const GeoSample> samples);

/// What one accelerometer direction is worth here: the stated sigma where they agree with `up`
/// within it. Else the vehicle accelerated, an error that neighbouring images share: then all of
/// them together count as one direction, wrong by three times what they differ.
double EstimateGravitySigma(std::span<const GeoSample> samples, const Eigen::Vector3d& up_in_model,
                            double stated_sigma_rad);

/// The rotation with the least turn that takes `up` to the z axis.
Eigen::Quaterniond UprightRotation(const Eigen::Vector3d& up_in_model);

/// Aligns a reconstruction to GNSS and gravity by a robust similarity. nullopt: fewer than three
/// positions fit, or they are too close together for their noise to give a scale.
std::optional<GeoAlignment> EstimateGeoAlignment(std::span<const GeoSample> samples,
                                                 const GeoAlignmentOptions& options);

}  // namespace waymark::mapping
