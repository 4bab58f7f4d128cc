// SPDX-License-Identifier: Apache-2.0
#include "mapping/geometry/rigid3.h"

#include <cmath>

namespace waymark {

Eigen::Quaterniond RotationFromVector(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  // sin(x / 2) / x tends to 1 / 2; the next term is below rounding for x < 1e-8.
  const double scale = angle < 1e-8 ? 0.5 : std::sin(angle / 2) / angle;
  Eigen::Quaterniond rotation;
  rotation.w() = std::cos(angle / 2);
  rotation.vec() = scale * rotation_vector;
  return rotation;
}

Eigen::Vector3d VectorFromRotation(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0 ? -1 : 1;  // q and -q are one rotation: take the short way
  const Eigen::Vector3d axis_part = sign * rotation.vec();
  const double sine = axis_part.norm();
  if (sine < 1e-8) return 2 * axis_part;
  return 2 * std::atan2(sine, sign * rotation.w()) / sine * axis_part;
}

Angle AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return Angle::Radians(VectorFromRotation(a.conjugate() * b).norm());
}

Rigid3 Perturb(const Rigid3& b_from_a, const Eigen::Matrix<double, 6, 1>& delta) {
  return {RotationFromVector(delta.tail<3>()) * b_from_a.rotation(),
          b_from_a.translation() + delta.head<3>()};
}

Eigen::Matrix<double, 6, 1> Difference(const Rigid3& from, const Rigid3& to) {
  Eigen::Matrix<double, 6, 1> delta;
  delta << to.translation() - from.translation(),
      VectorFromRotation(to.rotation() * from.rotation().conjugate());
  return delta;
}

Rigid3 Interpolate(const Rigid3& a, const Rigid3& b, double fraction) {
  return {a.rotation().slerp(fraction, b.rotation()),
          (1 - fraction) * a.translation() + fraction * b.translation()};
}

}  // namespace waymark
