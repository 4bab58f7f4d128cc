// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/motion/motion.h"

#include <cmath>
#include <numbers>

namespace waymark::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

double AngularFrequency(const Sway& sway) { return 2 * std::numbers::pi * sway.frequency_hz; }
double Phase(const Sway& sway, double time_s) {
  return AngularFrequency(sway) * time_s + sway.phase_rad;
}

}  // namespace

Rigid3 Motion::WorldFromBody(double time_s) const {
  Vector3d position = path_.At(time_s).value;
  for (const Sway& sway : sways_) position += std::sin(Phase(sway, time_s)) * sway.shift_m;
  return {WorldFromBodyRotation(time_s), position};
}

Vector3d Motion::VelocityInWorld(double time_s) const {
  Vector3d velocity = path_.At(time_s).velocity;
  for (const Sway& sway : sways_) {
    velocity += AngularFrequency(sway) * std::cos(Phase(sway, time_s)) * sway.shift_m;
  }
  return velocity;
}

Vector3d Motion::AccelerationInWorld(double time_s) const {
  Vector3d acceleration = path_.At(time_s).acceleration;
  for (const Sway& sway : sways_) {
    const double frequency = AngularFrequency(sway);
    acceleration -= frequency * frequency * std::sin(Phase(sway, time_s)) * sway.shift_m;
  }
  return acceleration;
}

Vector3d Motion::AngularVelocityInBody(double time_s) const {
  constexpr double kStep = 1e-4;
  const Eigen::Quaterniond before = WorldFromBodyRotation(time_s - kStep);
  const Eigen::Quaterniond after = WorldFromBodyRotation(time_s + kStep);
  return VectorFromRotation(before.conjugate() * after) / (2 * kStep);
}

Eigen::Quaterniond Motion::WorldFromBodyRotation(double time_s) const {
  const Vector3d velocity = path_.At(time_s).velocity;
  const Eigen::Vector2d gaze = gaze_.At(time_s).value;
  constexpr double kAtRest = 1e-6;  // m/s; slower has no direction
  const double heading =
      velocity.head<2>().norm() > kAtRest ? std::atan2(velocity.y(), velocity.x()) : 0;
  double yaw = heading + gaze[0];
  double pitch = gaze[1];
  double roll = 0;
  for (const Sway& sway : sways_) {
    const double swing = std::sin(Phase(sway, time_s));
    yaw += swing * sway.yaw_rad;
    pitch += swing * sway.pitch_rad;
    roll += swing * sway.roll_rad;
  }
  // About y (left) a positive angle looks down, hence the sign.
  return Eigen::Quaterniond(AngleAxisd(yaw, Vector3d::UnitZ()) *
                            AngleAxisd(-pitch, Vector3d::UnitY()) *
                            AngleAxisd(roll, Vector3d::UnitX()));
}

}  // namespace waymark::simulator
