// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "mapping/base/result.h"
#include "mapping/geometry/rigid3.h"

namespace waymark {

/// A similarity: `x_in_b = scale * (rotation * x_in_a) + translation`, scale > 0.
class Sim3 {
 public:
  Sim3() = default;
  Sim3(double scale, const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation)
      : scale_(scale), rigid_(rotation, translation) {}
  explicit Sim3(const Rigid3& rigid) : rigid_(rigid) {}

  double scale() const { return scale_; }
  const Eigen::Quaterniond& rotation() const { return rigid_.rotation(); }
  const Eigen::Vector3d& translation() const { return rigid_.translation(); }

  Sim3 Inverse() const {
    const Eigen::Quaterniond inverse = rotation().conjugate();
    return {1 / scale_, inverse, -(inverse * translation()) / scale_};
  }

  friend Sim3 operator*(const Sim3& c_from_b, const Sim3& b_from_a) {
    return {c_from_b.scale_ * b_from_a.scale_, c_from_b.rotation() * b_from_a.rotation(),
            c_from_b * b_from_a.translation()};
  }
  friend Eigen::Vector3d operator*(const Sim3& b_from_a, const Eigen::Vector3d& x_in_a) {
    return b_from_a.scale_ * (b_from_a.rotation() * x_in_a) + b_from_a.translation();
  }

 private:
  double scale_ = 1;
  Rigid3 rigid_;
};

/// Carries a metric pose through a similarity: the position is mapped, the rotation composed, and
/// the inner frame keeps its own metre (a camera does not shrink with its map).
Rigid3 CarryPose(const Sim3& c_from_b, const Rigid3& b_from_a);

/// The similarity (or, with `fixed_scale`, rigid motion) that minimises sum |to - T from|^2.
/// Shapes: equal lengths n >= 3, not all on one line.
/// Errors: InvalidArgument for other shapes or degenerate points.
/// Source: Umeyama, "Least-squares estimation of transformation parameters", PAMI 1991.
Result<Sim3> EstimateSimilarity(std::span<const Eigen::Vector3d> from,
                                std::span<const Eigen::Vector3d> to, bool fixed_scale = false);

}  // namespace waymark
