// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "examples/simulator/motion/motion.h"
#include "examples/simulator/random.h"
#include "examples/simulator/sensors/inertial.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::simulator {

/// Satellite positioning in a street: what matters is the slowly wandering part of its error.
struct SatelliteOptions {
  double rate_hz = 1;
  double white_m = 0.3;             ///< standard deviation per fix and horizontal axis
  double bias_m = 0.5;              ///< of the error that a recording starts with
  double walk_m_per_sqrt_s = 0.08;  ///< of that error's random walk
  double vertical_factor = 1.6;     ///< up is worse than sideways
  double reported_sigma_m = 1;      ///< what the receiver claims
};

/// A car's receiver, and a phone's with a standard deviation near 5 m.
inline SatelliteOptions CarReceiver() { return {}; }
inline SatelliteOptions PhoneReceiver() { return {1, 2, 4.5, 0.15, 1.6, 5}; }

struct SatelliteFix {
  double time_s;
  GeoPoint place;
  double sigma_m;
};

/// Fixes of an antenna at the body's origin. `plane` carries the world's east, north, up.
std::vector<SatelliteFix> MeasureSatellites(const Motion& motion, const Interval& interval,
                                            const TangentPlane& plane,
                                            const SatelliteOptions& options, Random random);

}  // namespace waymark::simulator
