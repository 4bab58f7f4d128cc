// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <vector>

#include "examples/simulator/motion/motion.h"
#include "examples/simulator/random.h"

namespace waymark::simulator {

/// Standard gravity, m/s^2, along world -z.
inline constexpr double kGravity = 9.80665;

/// From here to there in a motion's own time.
struct Interval {
  double first_s;
  double last_s;
};

/// A consumer-grade unit; noise is per sample, biases are constant over a recording.
struct InertialOptions {
  double rate_hz = 100;
  double accelerometer_noise = 0.05;  ///< m/s^2
  double accelerometer_bias = 0.03;   ///< m/s^2, standard deviation per axis
  double gyroscope_noise = 0.004;     ///< rad/s
  double gyroscope_bias = 0.002;      ///< rad/s, standard deviation per axis
};

struct InertialSample {
  double time_s;
  Eigen::Vector3d specific_force;    ///< m/s^2 in body axes: at rest 9.8 along up
  Eigen::Vector3d angular_velocity;  ///< rad/s in body axes
};

/// What an inertial unit at the body's origin, aligned with it, measures.
std::vector<InertialSample> MeasureInertial(const Motion& motion, const Interval& interval,
                                            const InertialOptions& options, Random random);

}  // namespace waymark::simulator
