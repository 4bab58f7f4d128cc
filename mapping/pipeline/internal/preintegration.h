// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <span>
#include <vector>

#include "mapping/experience/experience.h"

namespace waymark::mapping {

/// What an IMU felt since a moment it is called the beginning, in the sensor's axes at the
/// beginning. It knows neither how fast the sensor began nor where down was.
struct FeltMotion {
  SensorTime time;
  Eigen::Quaterniond begin_from_now;
  Eigen::Vector3d displacement;  ///< specific force integrated twice, m
};

/// How motion that was felt depends on the constant errors of gyroscope (rad/s) and accelerometer
/// (m/s^2): what is felt with a bias b taken off is, to first order around `bias`, that of
/// `motion[i]` changed by the Jacobians times (b - bias).
struct Preintegration {
  using Bias = Eigen::Matrix<double, 6, 1>;  ///< gyroscope, accelerometer

  Bias bias;
  std::vector<FeltMotion> motion;  ///< at each sample of the accelerometer
  std::vector<Eigen::Matrix<double, 3, 6>> displacement_by_bias;
  /// Rotation vector, in the axes at the beginning.
  std::vector<Eigen::Matrix3d> rotation_by_gyroscope_bias;
};

/// Integrates from the first sample of the accelerometer to its last. Both sensors are in the same
/// axes. Empty where either has a gap of more than 0.1 s.
Preintegration Preintegrate(std::span<const ImuRecord> accelerometer,
                            std::span<const ImuRecord> gyroscope, const Preintegration::Bias& bias);

}  // namespace waymark::mapping
