// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <span>

#include "mapping/estimation/bundle_adjustment.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

// The terms of cost (1): residuals in units of their sigma and derivatives by the tangents of poses
// (see Perturb), points and intrinsics.
namespace waymark::mapping::internal {

/// A pose as reprojection needs it.
struct ReadyPose {
  explicit ReadyPose(const Rigid3& world_from_camera)
      : camera_from_world(world_from_camera.rotation().conjugate().toRotationMatrix()),
        position(world_from_camera.translation()) {}

  Eigen::Matrix3d camera_from_world;
  Eigen::Vector3d position;
};

/// The derivative by the pose's translation is that by the point, negated.
struct ReprojectionTerm {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 3> by_point;
  Eigen::Matrix<double, 2, 3> by_rotation;
  Eigen::Matrix<double, 2, 8> by_parameters;
};

Eigen::Vector2d ReprojectionResidual(CameraKind kind, const double* parameters,
                                     const ReadyPose& pose, const Eigen::Vector3d& point,
                                     const Eigen::Vector2d& pixel_px, double sigma_px);
ReprojectionTerm LineariseReprojection(CameraKind kind, const double* parameters,
                                       const ReadyPose& pose, const Eigen::Vector3d& point,
                                       const Eigen::Vector2d& pixel_px, double sigma_px);

template <int kRows>
struct PoseTerm {
  Eigen::Matrix<double, kRows, 1> residual;
  Eigen::Matrix<double, kRows, 6> by_pose;
};

/// Camera centre against a prior.
PoseTerm<3> PositionTerm(const Rigid3& pose, const Eigen::Vector3d& prior, double sigma_m);
/// A direction of the camera that should be the world's "up": its horizontal part.
PoseTerm<2> UpTerm(const Rigid3& pose, const Eigen::Vector3d& up_in_camera, double sigma_rad);
/// A horizontal camera x axis.
PoseTerm<1> LevelTerm(const Rigid3& pose, double sigma_rad);

/// Where another camera of the rig was, against where it is mounted: it moved straight from
/// `before` to `after`.
struct RigTerm {
  Eigen::Vector3d residual;
  Eigen::Matrix<double, 3, 6> by_pose;
  Eigen::Matrix<double, 3, 6> by_before;
  Eigen::Matrix<double, 3, 6> by_after;
};
RigTerm LinkTerm(const BundleRigLink& link, const Rigid3& pose, const Rigid3& before,
                 const Rigid3& after);

/// Intrinsics against the initial ones; with two focal lengths one more residual holds their ratio.
struct IntrinsicsTerm {
  Eigen::Matrix<double, 9, 1> residual;
  Eigen::Matrix<double, 9, 8> by_parameters;
};
IntrinsicsTerm PriorOfIntrinsics(const BundleCamera& camera, const double* parameters);

/// Whether the parameter is part of the principal point or a tangential coefficient.
bool NeverMoves(CameraKind kind, int parameter);

/// A robust loss of a squared norm, as half of it enters the cost.
struct LossValue {
  double loss;   ///< of the squared norm
  double slope;  ///< its derivative, (0, 1]: the weight of the squared norm
};
LossValue EvaluateLoss(ObservationLoss loss, double scale, double squared);

}  // namespace waymark::mapping::internal
