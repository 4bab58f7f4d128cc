// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "examples/simulator/motion/motion.h"
#include "examples/simulator/random.h"
#include "examples/simulator/sensors/inertial.h"
#include "mapping/geometry/frames.h"

namespace waymark::simulator {

/// How a phone's visual-inertial odometry errs.
struct OdometryOptions {
  double rate_hz = 30;
  double yaw_walk_rad_per_sqrt_s = 0.0015;  ///< heading's random walk; 0.5 degrees after 40 s
  double scale_sigma = 0.01;                ///< one factor per walk on every step: 1 %
  double step_noise_m_per_sqrt_m = 0.01;    ///< random walk of the position per distance
  double tilt_rad = 0.002;  ///< error of its gravity, wandering within a few seconds
  double origin_m = 20;     ///< its origin lies within this of the world's
};

struct OdometrySample {
  double time_s;
  Transform<Vo, Device> vo_from_device;
};

/// A phone's own idea of its motion, in a frame of its own: any origin, any heading, z up.
std::vector<OdometrySample> SimulateOdometry(const Motion& motion, const Interval& interval,
                                             const OdometryOptions& options, Random random);

}  // namespace waymark::simulator
