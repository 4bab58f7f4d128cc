// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>
#undef CHECK  // glog's, which comes with Ceres; ours has another grammar

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "mapping/geometry/camera_model.h"

// Private to the sources of this folder: the only header that knows Ceres.
namespace waymark::mapping::internal {

/// A pose as Ceres holds it: quaternion x, y, z, w of world_from_camera, then its translation.
inline constexpr int kPoseSize = 7;

/// Perturb as a Ceres manifold. The cost functions below write derivatives by the tangent into the
/// first six columns of their "ambient" Jacobians, and this manifold's derivative is the matching
/// identity: that spares a product per residual.
class PerturbManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseSize; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* pose, const double* delta, double* moved) const override;
  bool PlusJacobian(const double* pose, double* jacobian) const override;
  bool Minus(const double* to, const double* from, double* delta) const override;
  bool MinusJacobian(const double* pose, double* jacobian) const override;
};

/// Reprojection in units of sigma. Parameters: pose, point, intrinsics.
class ReprojectionCost final : public ceres::CostFunction {
 public:
  ReprojectionCost(CameraKind kind, const Eigen::Vector2d& pixel_px, double sigma_px);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  CameraKind kind_;
  Eigen::Vector2d pixel_px_;
  double weight_;
};

/// Camera centre against a prior. Parameter: pose.
class PositionCost final : public ceres::SizedCostFunction<3, kPoseSize> {
 public:
  PositionCost(const Eigen::Vector3d& prior, double sigma_m)
      : prior_(prior), weight_(1 / sigma_m) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector3d prior_;
  double weight_;
};

/// Where another camera of the rig was, against where it is mounted: it moved straight from
/// `before` to `after`. Parameters: the camera's pose, before, after.
class RigCost final : public ceres::SizedCostFunction<3, kPoseSize, kPoseSize, kPoseSize> {
 public:
  RigCost(double share, const Eigen::Vector3d& offset_in_camera, double sigma_m)
      : share_(share), offset_in_camera_(offset_in_camera), weight_(1 / sigma_m) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  double share_;
  Eigen::Vector3d offset_in_camera_;
  double weight_;
};

/// A direction of the camera that should be the world's "up": two residuals, its horizontal
/// part. Parameter: pose.
class UpCost final : public ceres::SizedCostFunction<2, kPoseSize> {
 public:
  UpCost(const Eigen::Vector3d& up_in_camera, double sigma_rad)
      : up_in_camera_(up_in_camera), weight_(1 / sigma_rad) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector3d up_in_camera_;
  double weight_;
};

/// A horizontal camera x axis. Parameter: pose.
class LevelCost final : public ceres::SizedCostFunction<1, kPoseSize> {
 public:
  explicit LevelCost(double sigma_rad) : weight_(1 / sigma_rad) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  double weight_;
};

/// Intrinsics against initial ones; a weight of zero leaves a parameter free. With two focal
/// lengths (the first two parameters) one more residual holds their ratio.
class IntrinsicsCost final : public ceres::CostFunction {
 public:
  IntrinsicsCost(Eigen::VectorXd initial, Eigen::VectorXd weights, double aspect_weight);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::VectorXd initial_;
  Eigen::VectorXd weights_;
  double aspect_weight_;
};

}  // namespace waymark::mapping::internal
