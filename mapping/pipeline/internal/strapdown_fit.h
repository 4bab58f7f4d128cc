// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <limits>
#include <span>

#include "mapping/pipeline/internal/gnss_track.h"
#include "mapping/pipeline/internal/preintegration.h"

namespace waymark::mapping {

/// How far an inertial unit's constant errors may be from zero, standard deviation per axis.
struct InertialBiasSigma {
  double gyroscope_rad_per_s = 0.005;
  double accelerometer_mps2 = 0.1;
};

/// How a sensor stood and moved at the beginning of a stretch of motion, with its biases.
struct StrapdownFit {
  using Vector = Eigen::Matrix<double, 15, 1>;  ///< position, velocity, turn in map axes, biases
  using Matrix = Eigen::Matrix<double, 15, 15>;

  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Quaterniond map_from_sensor = Eigen::Quaterniond::Identity();
  Preintegration::Bias bias = Preintegration::Bias::Zero();

  int fixes = 0;
  double rms_sigmas = std::numeric_limits<double>::infinity();  ///< of the fixes
  Matrix covariance = Matrix::Zero();

  /// Of the map's horizontal axes as the sensor sees them at a sample; the larger of the two.
  double TiltSigmaRad(const Preintegration& felt, std::size_t sample) const;
};

/// The fit to GNSS of what was felt: only one attitude makes specific force, integrated twice in
/// the frame that the gyroscope carries, lead from fix to fix. Gauss-Newton with Huber weights from
/// several guesses of the heading, which stays open while the vehicle neither turns nor
/// accelerates. `fixes` is 0 when none lies within the motion.
StrapdownFit FitStrapdown(const Preintegration& felt, std::span<const GnssFix> fixes,
                          const InertialBiasSigma& bias_sigma);

}  // namespace waymark::mapping
