// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/sensors/inertial.h"

namespace waymark::simulator {

std::vector<InertialSample> MeasureInertial(const Motion& motion, const Interval& interval,
                                            const InertialOptions& options, Random random) {
  const Eigen::Vector3d gravity(0, 0, -kGravity);
  const Eigen::Vector3d force_bias = random.NormalVector(options.accelerometer_bias);
  const Eigen::Vector3d rate_bias = random.NormalVector(options.gyroscope_bias);
  std::vector<InertialSample> samples;
  const int count = static_cast<int>((interval.last_s - interval.first_s) * options.rate_hz) + 1;
  for (int i = 0; i < count; ++i) {
    const double time_s = interval.first_s + i / options.rate_hz;
    const Eigen::Quaterniond body_from_world = motion.WorldFromBody(time_s).rotation().conjugate();
    const Eigen::Vector3d force = body_from_world * (motion.AccelerationInWorld(time_s) - gravity);
    samples.push_back({time_s,
                       force + force_bias + random.NormalVector(options.accelerometer_noise),
                       motion.AngularVelocityInBody(time_s) + rate_bias +
                           random.NormalVector(options.gyroscope_noise)});
  }
  return samples;
}

}  // namespace waymark::simulator
