// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/internal/bundle_terms.h"

#include <algorithm>
#include <cmath>

#include "mapping/estimation/projection_derivatives.h"

namespace waymark::mapping::internal {
namespace {

/// A point may cross the camera plane during a step; the cost there only has to be large.
constexpr double kLeastDepth = 1e-6;

Eigen::Vector3d InFront(const ReadyPose& pose, const Eigen::Vector3d& offset) {
  Eigen::Vector3d x_in_camera = pose.camera_from_world * offset;
  if (!(x_in_camera.z() > kLeastDepth)) x_in_camera.z() = kLeastDepth;
  return x_in_camera;
}

bool HasTwoFocals(CameraKind kind) {
  return kind == CameraKind::kPinhole || kind == CameraKind::kOpenCv;
}

int CentreOf(CameraKind kind) { return HasTwoFocals(kind) ? 2 : 1; }

}  // namespace

Eigen::Vector2d ReprojectionResidual(CameraKind kind, const double* parameters,
                                     const ReadyPose& pose, const Eigen::Vector3d& point,
                                     const Eigen::Vector2d& pixel_px, double sigma_px) {
  const Eigen::Vector2d normalized = InFront(pose, point - pose.position).hnormalized();
  return (ProjectNormalized<double>(kind, parameters, normalized) - pixel_px) / sigma_px;
}

ReprojectionTerm LineariseReprojection(CameraKind kind, const double* parameters,
                                       const ReadyPose& pose, const Eigen::Vector3d& point,
                                       const Eigen::Vector2d& pixel_px, double sigma_px) {
  const Eigen::Vector3d offset = point - pose.position;
  const Eigen::Vector3d x_in_camera = InFront(pose, offset);
  const ProjectionWithDerivatives projection =
      ProjectWithDerivatives(kind, parameters, x_in_camera.hnormalized());
  const Eigen::Matrix<double, 2, 3> by_camera_point =
      projection.by_normalized * NormalizationDerivative(x_in_camera) / sigma_px;
  ReprojectionTerm term;
  term.residual = (projection.pixel_px - pixel_px) / sigma_px;
  term.by_point = by_camera_point * pose.camera_from_world;
  for (int row : {0, 1}) {
    term.by_rotation.row(row) = -offset.cross(term.by_point.row(row).transpose());
  }
  term.by_parameters = projection.by_parameters / sigma_px;
  return term;
}

PoseTerm<3> PositionTerm(const Rigid3& pose, const Eigen::Vector3d& prior, double sigma_m) {
  PoseTerm<3> term{(pose.translation() - prior) / sigma_m, {}};
  term.by_pose << Eigen::Matrix3d::Identity() / sigma_m, Eigen::Matrix3d::Zero();
  return term;
}

PoseTerm<2> UpTerm(const Rigid3& pose, const Eigen::Vector3d& up_in_camera, double sigma_rad) {
  const Eigen::Vector3d up_in_world = pose.rotation() * up_in_camera;
  PoseTerm<2> term{up_in_world.head<2>() / sigma_rad, {}};
  term.by_pose << Eigen::Matrix<double, 2, 3>::Zero(),
      -CrossMatrix(up_in_world).topRows<2>() / sigma_rad;
  return term;
}

PoseTerm<1> LevelTerm(const Rigid3& pose, double sigma_rad) {
  const Eigen::Vector3d x_axis_in_world = pose.rotation() * Eigen::Vector3d::UnitX();
  PoseTerm<1> term{x_axis_in_world.tail<1>() / sigma_rad, {}};
  term.by_pose << Eigen::RowVector3d::Zero(), -CrossMatrix(x_axis_in_world).row(2) / sigma_rad;
  return term;
}

RigTerm LinkTerm(const BundleRigLink& link, const Rigid3& pose, const Rigid3& before,
                 const Rigid3& after) {
  const Eigen::Matrix3d camera_from_world = pose.rotation().conjugate().toRotationMatrix();
  const Eigen::Vector3d offset = (1 - link.share) * before.translation() +
                                 link.share * after.translation() - pose.translation();
  const Eigen::Matrix3d by_position = camera_from_world / link.sigma_m;
  RigTerm term;
  term.residual = (camera_from_world * offset - link.offset_in_camera) / link.sigma_m;
  term.by_pose << -by_position, by_position * CrossMatrix(offset);
  term.by_before << (1 - link.share) * by_position, Eigen::Matrix3d::Zero();
  term.by_after << link.share * by_position, Eigen::Matrix3d::Zero();
  return term;
}

IntrinsicsTerm PriorOfIntrinsics(const BundleCamera& camera, const double* parameters) {
  const CameraKind kind = camera.model.kind();
  const std::span<const double> initial = camera.initial.parameters();
  IntrinsicsTerm term{Eigen::Matrix<double, 9, 1>::Zero(), Eigen::Matrix<double, 9, 8>::Zero()};
  for (int p = 0; p < static_cast<int>(ParameterCount(kind)); ++p) {
    if (NeverMoves(kind, p)) continue;
    const double from = initial[static_cast<std::size_t>(p)];
    const double sigma = p < CentreOf(kind) ? camera.focal_sigma_share * from : camera.lens_sigma;
    term.residual(p) = (parameters[p] - from) / sigma;
    term.by_parameters(p, p) = 1 / sigma;
  }
  if (HasTwoFocals(kind)) {
    const double weight = 1 / camera.aspect_sigma;
    term.residual(8) = weight * (parameters[0] / initial[0] - parameters[1] / initial[1]);
    term.by_parameters(8, 0) = weight / initial[0];
    term.by_parameters(8, 1) = -weight / initial[1];
  }
  return term;
}

bool NeverMoves(CameraKind kind, int parameter) {
  constexpr int kFirstTangential = 6;
  return parameter == CentreOf(kind) || parameter == CentreOf(kind) + 1 ||
         parameter >= kFirstTangential;
}

LossValue EvaluateLoss(ObservationLoss loss, double scale, double squared) {
  const double bound = scale * scale;
  switch (loss) {
    case ObservationLoss::kSquared:
      break;
    case ObservationLoss::kHuber:
      if (squared <= bound) break;
      return {2 * scale * std::sqrt(squared) - bound, scale / std::sqrt(squared)};
    case ObservationLoss::kCauchy:
      return {bound * std::log1p(squared / bound), 1 / (1 + squared / bound)};
  }
  return {squared, 1};
}

}  // namespace waymark::mapping::internal
