// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/sensors/satellite.h"

#include <cmath>

namespace waymark::simulator {

std::vector<SatelliteFix> MeasureSatellites(const Motion& motion, const Interval& interval,
                                            const TangentPlane& plane,
                                            const SatelliteOptions& options, Random random) {
  const Eigen::Vector3d axes(1, 1, options.vertical_factor);
  Eigen::Vector3d bias = random.NormalVector(options.bias_m);
  const double walk_m = options.walk_m_per_sqrt_s / std::sqrt(options.rate_hz);
  std::vector<SatelliteFix> fixes;
  const int count = static_cast<int>((interval.last_s - interval.first_s) * options.rate_hz) + 1;
  for (int i = 0; i < count; ++i) {
    const double time_s = interval.first_s + i / options.rate_hz;
    const Eigen::Vector3d error = bias + random.NormalVector(options.white_m);
    const Eigen::Vector3d measured =
        motion.WorldFromBody(time_s).translation() + axes.cwiseProduct(error);
    fixes.push_back({time_s, plane.ToGeo(Point<Map>(measured)), options.reported_sigma_m});
    bias += random.NormalVector(walk_m);
  }
  return fixes;
}

}  // namespace waymark::simulator
