// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "mapping/geometry/angle.h"

namespace waymark {

/// A rotation and a translation: `x_in_b = b_from_a * x_in_a`. The rotation is kept normalised.
/// Names carry the frames here; public signatures use Transform<To, From>.
class Rigid3 {
 public:
  Rigid3() = default;
  Rigid3(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation)
      : rotation_(rotation.normalized()), translation_(translation) {}

  const Eigen::Quaterniond& rotation() const { return rotation_; }
  const Eigen::Vector3d& translation() const { return translation_; }

  Rigid3 Inverse() const {
    const Eigen::Quaterniond inverse = rotation_.conjugate();
    return {inverse, -(inverse * translation_)};
  }

  friend Rigid3 operator*(const Rigid3& c_from_b, const Rigid3& b_from_a) {
    return {c_from_b.rotation_ * b_from_a.rotation_,
            c_from_b.rotation_ * b_from_a.translation_ + c_from_b.translation_};
  }
  friend Eigen::Vector3d operator*(const Rigid3& b_from_a, const Eigen::Vector3d& x_in_a) {
    return b_from_a.rotation_ * x_in_a + b_from_a.translation_;
  }

 private:
  Eigen::Quaterniond rotation_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation_ = Eigen::Vector3d::Zero();
};

/// The matrix of the cross product: `CrossMatrix(v) * x == v.cross(x)`.
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

/// The rotation by |v| radians about v, and its inverse (angle in [0, pi]).
Eigen::Quaterniond RotationFromVector(const Eigen::Vector3d& rotation_vector);
Eigen::Vector3d VectorFromRotation(const Eigen::Quaterniond& rotation);

/// The angle of the rotation that takes one to the other, in [0, pi].
Angle AngleBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

/// The project's only tangent: delta = (translation, rotation vector), both in the outer frame b,
/// decoupled: t' = t + delta.head<3>(), R' = Exp(delta.tail<3>()) R. Covariances of poses are of
/// this delta. `Difference` is the inverse: Perturb(a, Difference(a, b)) == b.
Rigid3 Perturb(const Rigid3& b_from_a, const Eigen::Matrix<double, 6, 1>& delta);
Eigen::Matrix<double, 6, 1> Difference(const Rigid3& from, const Rigid3& to);

/// Between two poses: translation along the chord, rotation along the great circle; 0 -> a, 1 -> b.
Rigid3 Interpolate(const Rigid3& a, const Rigid3& b, double fraction);

}  // namespace waymark
