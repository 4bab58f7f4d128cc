// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <span>

#include "mapping/estimation/geo_sample.h"

namespace waymark::mapping {

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

}  // namespace waymark::mapping
