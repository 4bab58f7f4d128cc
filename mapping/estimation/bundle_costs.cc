// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/internal/bundle_costs.h"

#include "mapping/estimation/projection_derivatives.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping::internal {
namespace {

using RowMajor27 = Eigen::Matrix<double, 2, kPoseSize, Eigen::RowMajor>;
using RowMajor23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;

Rigid3 ReadPose(const double* p) {
  return {Eigen::Quaterniond(p[3], p[0], p[1], p[2]), Eigen::Vector3d(p[4], p[5], p[6])};
}

}  // namespace

bool PerturbManifold::Plus(const double* pose, const double* delta, double* moved) const {
  const Rigid3 out = Perturb(ReadPose(pose), Eigen::Map<const Eigen::Matrix<double, 6, 1>>(delta));
  Eigen::Map<Eigen::Matrix<double, kPoseSize, 1>> result(moved);
  result << out.rotation().coeffs(), out.translation();
  return true;
}

bool PerturbManifold::PlusJacobian(const double* /*pose*/, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kPoseSize, 6, Eigen::RowMajor>>(jacobian).setIdentity();
  return true;
}

bool PerturbManifold::Minus(const double* to, const double* from, double* delta) const {
  Eigen::Map<Eigen::Matrix<double, 6, 1>> out(delta);
  out = Difference(ReadPose(from), ReadPose(to));
  return true;
}

bool PerturbManifold::MinusJacobian(const double* /*pose*/, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 6, kPoseSize, Eigen::RowMajor>>(jacobian).setIdentity();
  return true;
}

ReprojectionCost::ReprojectionCost(CameraKind kind, const Eigen::Vector2d& pixel_px,
                                   double sigma_px)
    : kind_(kind), pixel_px_(pixel_px), weight_(1 / sigma_px) {
  set_num_residuals(2);
  mutable_parameter_block_sizes()->assign({kPoseSize, 3, static_cast<int>(ParameterCount(kind))});
}

bool ReprojectionCost::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  const Rigid3 world_from_camera = ReadPose(parameters[0]);
  const Eigen::Map<const Eigen::Vector3d> point(parameters[1]);
  const Eigen::Matrix3d camera_from_world =
      world_from_camera.rotation().conjugate().toRotationMatrix();
  const Eigen::Vector3d offset = point - world_from_camera.translation();
  Eigen::Vector3d x_in_camera = camera_from_world * offset;
  // A point may cross the camera plane during a step; the cost there only has to be large.
  if (!(x_in_camera.z() > 1e-6)) x_in_camera.z() = 1e-6;
  const ProjectionWithDerivatives projection =
      ProjectWithDerivatives(kind_, parameters[2], x_in_camera.hnormalized());
  Eigen::Map<Eigen::Vector2d> residual(residuals);
  residual = weight_ * (projection.pixel_px - pixel_px_);
  if (!residual.allFinite()) return false;
  if (jacobians == nullptr) return true;
  const Eigen::Matrix<double, 2, 3> by_point =
      weight_ * projection.by_normalized * NormalizationDerivative(x_in_camera) * camera_from_world;
  if (jacobians[0] != nullptr) {
    Eigen::Map<RowMajor27>(jacobians[0]) << -by_point, by_point * CrossMatrix(offset),
        Eigen::Vector2d::Zero();
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<RowMajor23> out(jacobians[1]);
    out = by_point;
  }
  if (jacobians[2] != nullptr) {
    const auto count = static_cast<Eigen::Index>(ParameterCount(kind_));
    Eigen::Map<Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>>(jacobians[2], 2, count) =
        weight_ * projection.by_parameters.leftCols(count);
  }
  return true;
}

bool PositionCost::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> position(parameters[0] + 4);
  Eigen::Map<Eigen::Vector3d> residual(residuals);
  residual = weight_ * (position - prior_);
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 3, kPoseSize, Eigen::RowMajor>> jacobian(jacobians[0]);
    jacobian.setZero();
    jacobian.leftCols<3>().diagonal().setConstant(weight_);
  }
  return true;
}

bool RigCost::Evaluate(double const* const* parameters, double* residuals,
                       double** jacobians) const {
  using RowMajor37 = Eigen::Matrix<double, 3, kPoseSize, Eigen::RowMajor>;
  const Rigid3 pose = ReadPose(parameters[0]);
  const Eigen::Map<const Eigen::Vector3d> before(parameters[1] + 4);
  const Eigen::Map<const Eigen::Vector3d> after(parameters[2] + 4);
  const Eigen::Matrix3d camera_from_world = pose.rotation().conjugate().toRotationMatrix();
  const Eigen::Vector3d offset = (1 - share_) * before + share_ * after - pose.translation();
  Eigen::Map<Eigen::Vector3d> residual(residuals);
  residual = weight_ * (camera_from_world * offset - offset_in_camera_);
  if (jacobians == nullptr) return true;
  const Eigen::Matrix3d by_position = weight_ * camera_from_world;
  if (jacobians[0] != nullptr) {
    Eigen::Map<RowMajor37>(jacobians[0]) << -by_position, by_position * CrossMatrix(offset),
        Eigen::Vector3d::Zero();
  }
  const auto write = [&](double* jacobian, double share) {
    if (jacobian == nullptr) return;
    Eigen::Map<RowMajor37> out(jacobian);
    out.setZero();
    out.leftCols<3>() = share * by_position;
  };
  write(jacobians[1], 1 - share_);
  write(jacobians[2], share_);
  return true;
}

bool UpCost::Evaluate(double const* const* parameters, double* residuals,
                      double** jacobians) const {
  const Eigen::Vector3d up_in_world = ReadPose(parameters[0]).rotation() * up_in_camera_;
  residuals[0] = weight_ * up_in_world.x();
  residuals[1] = weight_ * up_in_world.y();
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<RowMajor27> jacobian(jacobians[0]);
    jacobian.setZero();
    jacobian.middleCols<3>(3) = -weight_ * CrossMatrix(up_in_world).topRows<2>();
  }
  return true;
}

bool LevelCost::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  const Eigen::Vector3d x_axis_in_world =
      ReadPose(parameters[0]).rotation() * Eigen::Vector3d::UnitX();
  residuals[0] = weight_ * x_axis_in_world.z();
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 1, kPoseSize, Eigen::RowMajor>> jacobian(jacobians[0]);
    jacobian.setZero();
    jacobian.middleCols<3>(3) = -weight_ * CrossMatrix(x_axis_in_world).row(2);
  }
  return true;
}

IntrinsicsCost::IntrinsicsCost(Eigen::VectorXd initial, Eigen::VectorXd weights,
                               double aspect_weight)
    : initial_(std::move(initial)), weights_(std::move(weights)), aspect_weight_(aspect_weight) {
  set_num_residuals(static_cast<int>(initial_.size()) + 1);
  mutable_parameter_block_sizes()->assign({static_cast<int>(initial_.size())});
}

bool IntrinsicsCost::Evaluate(double const* const* parameters, double* residuals,
                              double** jacobians) const {
  const Eigen::Index count = initial_.size();
  const Eigen::Map<const Eigen::VectorXd> values(parameters[0], count);
  Eigen::Map<Eigen::VectorXd> residual(residuals, count + 1);
  residual.head(count) = weights_.cwiseProduct(values - initial_);
  const bool has_aspect = aspect_weight_ > 0;
  residual(count) =
      has_aspect ? aspect_weight_ * (values(0) / initial_(0) - values(1) / initial_(1)) : 0;
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> jacobian(
        jacobians[0], count + 1, count);
    jacobian.setZero();
    jacobian.topRows(count) = weights_.asDiagonal();
    if (has_aspect) {
      jacobian(count, 0) = aspect_weight_ / initial_(0);
      jacobian(count, 1) = -aspect_weight_ / initial_(1);
    }
  }
  return true;
}

}  // namespace waymark::mapping::internal
