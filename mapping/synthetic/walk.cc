// SPDX-License-Identifier: Apache-2.0
#include "mapping/synthetic/walk.h"

#include <numbers>

namespace waymark::mapping {

Rigid3 PlaceCamera(const Eigen::Vector3d& position, double yaw_rad, double pitch_rad,
                   double roll_rad) {
  // Camera axes of a level camera that looks north: x east, y down, z north.
  Eigen::Matrix3d level;
  level << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const Eigen::Quaterniond rotation =
      RotationFromVector({0, 0, yaw_rad}) * RotationFromVector({pitch_rad, 0, 0}) *
      Eigen::Quaterniond(level) * RotationFromVector({0, 0, roll_rad});
  return {rotation, position};
}

std::vector<Rigid3> WalkStraight(const Eigen::Vector3d& start, double step_m, int count,
                                 double yaw_rad) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i) {
    poses.push_back(PlaceCamera(start + Eigen::Vector3d(0, i * step_m, 0), yaw_rad));
  }
  return poses;
}

std::vector<Rigid3> WalkCircle(double radius_m, double height_m, int count) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i) {
    const double yaw = 2 * std::numbers::pi * i / count;
    const Eigen::Vector3d ahead(-std::sin(yaw), std::cos(yaw), 0);
    poses.push_back(PlaceCamera(radius_m * ahead + Eigen::Vector3d(0, 0, height_m), yaw));
  }
  return poses;
}

std::vector<Rigid3> TurnInPlace(const Eigen::Vector3d& position, double step_rad, int count) {
  std::vector<Rigid3> poses;
  for (int i = 0; i < count; ++i) poses.push_back(PlaceCamera(position, i * step_rad));
  return poses;
}

}  // namespace waymark::mapping
