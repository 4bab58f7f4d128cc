// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <vector>

#include "examples/simulator/motion/cubic_spline.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::simulator {

/// Rocking of a car on its springs or of a walker's hand; amplitudes of one sine each.
struct Sway {
  double frequency_hz;
  double phase_rad;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< along world axes
  double yaw_rad = 0;
  double pitch_rad = 0;
  double roll_rad = 0;
};

/// A smooth motion of a body (x forward, y left, z up) through the world: it follows a spline,
/// looks along it (east while at rest) plus a gaze, and sways. What inertial sensors measure
/// follows from its derivatives. Immutable, thread-safe.
class Motion {
 public:
  /// `gaze` is (yaw, pitch) in radians against the direction of travel, left and up positive.
  Motion(CubicSpline<3> path, CubicSpline<2> gaze, std::vector<Sway> sways)
      : path_(std::move(path)), gaze_(std::move(gaze)), sways_(std::move(sways)) {}

  Rigid3 WorldFromBody(double time_s) const;
  Eigen::Vector3d VelocityInWorld(double time_s) const;
  Eigen::Vector3d AccelerationInWorld(double time_s) const;
  /// By central difference over 0.2 ms: to about 1e-8 rad/s.
  Eigen::Vector3d AngularVelocityInBody(double time_s) const;

 private:
  Eigen::Quaterniond WorldFromBodyRotation(double time_s) const;

  CubicSpline<3> path_;
  CubicSpline<2> gaze_;
  std::vector<Sway> sways_;
};

}  // namespace waymark::simulator
