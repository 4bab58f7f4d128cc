// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/preintegration.h"

#include <cmath>
#include <iterator>

#include "mapping/base/time.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {
namespace {

constexpr double kMaxGapS = 0.1;

/// Empty when there is a gap.
std::vector<FeltMotion> Integrate(std::span<const ImuRecord> accelerometer,
                                  std::span<const ImuRecord> gyroscope,
                                  const Preintegration::Bias& bias) {
  const Eigen::Vector3d rate_bias = bias.head<3>();
  const Eigen::Vector3d force_bias = bias.tail<3>();
  std::vector<FeltMotion> felt;
  felt.reserve(accelerometer.size());
  Eigen::Quaterniond begin_from_now = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();
  auto rate = gyroscope.begin();
  for (std::size_t i = 0; i < accelerometer.size(); ++i) {
    const SensorTime now = accelerometer[i].time;
    felt.push_back({now, begin_from_now, displacement});
    if (i + 1 == accelerometer.size()) break;
    const double step_s = Seconds(accelerometer[i + 1].time - now);
    while (rate != gyroscope.end() && std::next(rate) != gyroscope.end() &&
           std::next(rate)->time <= now) {
      ++rate;
    }
    if (rate == gyroscope.end() || step_s > kMaxGapS ||
        std::abs(Seconds(now - rate->time)) > kMaxGapS) {
      return {};
    }
    // The sensor turns by the mean of the samples at both ends of the step.
    const auto after = std::next(rate) != gyroscope.end() ? std::next(rate) : rate;
    const Eigen::Vector3d mean_rate = 0.5 * (rate->value + after->value) - rate_bias;
    const Eigen::Quaterniond next = begin_from_now * RotationFromVector(mean_rate * step_s);
    const Eigen::Vector3d force = 0.5 * (begin_from_now * (accelerometer[i].value - force_bias) +
                                         next * (accelerometer[i + 1].value - force_bias));
    displacement += velocity * step_s + 0.5 * step_s * step_s * force;
    velocity += force * step_s;
    begin_from_now = next;
  }
  return felt;
}

}  // namespace

Preintegration Preintegrate(std::span<const ImuRecord> accelerometer,
                            std::span<const ImuRecord> gyroscope,
                            const Preintegration::Bias& bias) {
  constexpr double kStep = 1e-5;  // rad/s or m/s^2; what follows is close to linear in it
  Preintegration result{.bias = bias,
                        .motion = Integrate(accelerometer, gyroscope, bias),
                        .displacement_by_bias = {},
                        .rotation_by_gyroscope_bias = {}};
  const std::size_t count = result.motion.size();
  result.displacement_by_bias.resize(count);
  result.rotation_by_gyroscope_bias.resize(count);
  if (count == 0) return result;
  for (int axis = 0; axis < 6; ++axis) {
    const auto changed =
        Integrate(accelerometer, gyroscope, bias + kStep * Preintegration::Bias::Unit(axis));
    for (std::size_t i = 0; i < count; ++i) {
      const FeltMotion& was = result.motion[i];
      result.displacement_by_bias[i].col(axis) =
          (changed[i].displacement - was.displacement) / kStep;
      if (axis >= 3) continue;
      result.rotation_by_gyroscope_bias[i].col(axis) =
          VectorFromRotation(changed[i].begin_from_now * was.begin_from_now.conjugate()) / kStep;
    }
  }
  return result;
}

}  // namespace waymark::mapping
