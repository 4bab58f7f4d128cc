// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/sensors/odometry.h"

#include <cmath>
#include <numbers>

namespace waymark::simulator {

std::vector<OdometrySample> SimulateOdometry(const Motion& motion, const Interval& interval,
                                             const OdometryOptions& options, Random random) {
  constexpr double kTiltMemory = 4;  // seconds
  const double step_s = 1 / options.rate_hz;
  const double scale = 1 + random.Normal(options.scale_sigma);
  double yaw = random.Uniform(-std::numbers::pi, std::numbers::pi);
  Eigen::Vector3d position(random.Uniform(-options.origin_m, options.origin_m),
                           random.Uniform(-options.origin_m, options.origin_m),
                           random.Uniform(-1, 1));
  Eigen::Vector2d tilt(random.Normal(options.tilt_rad), random.Normal(options.tilt_rad));
  const double keep = std::exp(-step_s / kTiltMemory);
  const double renew = options.tilt_rad * std::sqrt(1 - keep * keep);

  std::vector<OdometrySample> samples;
  Eigen::Vector3d last = motion.WorldFromBody(interval.first_s).translation();
  const int count = static_cast<int>((interval.last_s - interval.first_s) * options.rate_hz) + 1;
  for (int i = 0; i < count; ++i) {
    const double time_s = interval.first_s + i * step_s;
    const Rigid3 world_from_body = motion.WorldFromBody(time_s);
    const Eigen::Vector3d step = world_from_body.translation() - last;
    last = world_from_body.translation();
    const Eigen::Quaterniond heading = RotationFromVector({0, 0, yaw});
    position += heading * (scale * step) +
                random.NormalVector(options.step_noise_m_per_sqrt_m * std::sqrt(step.norm()));
    const Eigen::Quaterniond leaning = RotationFromVector({tilt.x(), tilt.y(), 0});
    samples.push_back(
        {time_s, Transform<Vo, Device>(heading * leaning * world_from_body.rotation(), position)});
    yaw += random.Normal(options.yaw_walk_rad_per_sqrt_s * std::sqrt(step_s));
    tilt = keep * tilt + Eigen::Vector2d(random.Normal(renew), random.Normal(renew));
  }
  return samples;
}

}  // namespace waymark::simulator
