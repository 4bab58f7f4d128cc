// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "localiser/odometry_alignment.h"
#include "tests/support/random_geometry.h"

namespace waymark::localiser {

struct WalkNoise {
  double drift_share = 0;      ///< of the distance walked
  double yaw_drift_rad_m = 0;  ///< per metre walked
  double fix_sigma_m = 0;
  double fix_sigma_rad = 0;
};

/// A person who walks in a wide circle with a phone whose odometry drifts.
class SimulatedWalk {
 public:
  SimulatedWalk(const WalkNoise& noise, std::uint64_t seed) : noise_(noise), random_(seed) {}

  static constexpr double kSpeedMps = 1.4;

  DeviceTime Time(double seconds) const {
    return FromNanoseconds<DeviceTime>(static_cast<std::int64_t>(seconds * 1e9));
  }
  Transform<Map, Device> MapFromDevice(double seconds) const {
    const double walked_m = kSpeedMps * seconds;
    const double heading = walked_m / kRadiusM;
    return Pose<Map>(heading, {kRadiusM * std::sin(heading), kRadiusM * std::cos(heading), 1.6});
  }
  Transform<Vo, Device> VoFromDevice(double seconds) const {
    const double walked_m = kSpeedMps * seconds;
    const Rigid3 drift(RotationFromVector({0, 0, noise_.yaw_drift_rad_m * walked_m}),
                       noise_.drift_share * walked_m * Eigen::Vector3d(0.8, -0.6, 0));
    const Rigid3 vo_from_map(RotationFromVector({0, 0, 2.2}), Eigen::Vector3d(310, -125, 7));
    return Transform<Vo, Device>(vo_from_map * drift * MapFromDevice(seconds).rigid());
  }
  /// A fix with noise, as a localiser would answer.
  MapFix Fix(double seconds) {
    Eigen::Matrix<double, 6, 1> noise;
    for (int i = 0; i < 3; ++i) noise(i) = random_.Normal(noise_.fix_sigma_m);
    for (int i = 3; i < 6; ++i) noise(i) = random_.Normal(noise_.fix_sigma_rad);
    return FixAt(seconds, Perturb(MapFromDevice(seconds).rigid(), noise));
  }
  /// A fix in a wrong place, upright as false ones are that passed a gravity check.
  MapFix FalseFix(double seconds) {
    Eigen::Matrix<double, 6, 1> error = Eigen::Matrix<double, 6, 1>::Zero();
    error << random_.Vector(60), 0, 0, random_.Uniform(-3, 3);
    return FixAt(seconds, Perturb(MapFromDevice(seconds).rigid(), error));
  }
  MapFix FixAt(double seconds, const Rigid3& map_from_device) const {
    return {.time = Time(seconds),
            .vo_from_device = VoFromDevice(seconds),
            .map_from_device = Transform<Map, Device>(map_from_device),
            .covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-4,
            .submap = SubmapId("a"),
            .submap_from_camera = Transform<Submap, Camera>(map_from_device),
            .camera_from_device = {}};
  }
  /// How far the phone's content is off right now.
  double PositionError(const Alignment& alignment, double seconds) const {
    const Transform<Map, Device> seen = *alignment.map_from_vo * VoFromDevice(seconds);
    return (seen.translation() - MapFromDevice(seconds).translation()).norm();
  }

 private:
  static constexpr double kRadiusM = 40;

  template <typename Frame>
  static Transform<Frame, Device> Pose(double heading, const Eigen::Vector3d& position) {
    const Eigen::Quaterniond upright(RotationFromVector({-1.5707963, 0, 0}));
    return {RotationFromVector({0, 0, -heading}) * upright, position};
  }

  WalkNoise noise_;
  support::RandomGeometry random_;
};

}  // namespace waymark::localiser
