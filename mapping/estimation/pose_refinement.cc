// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/pose_refinement.h"

#include <Eigen/Cholesky>

#include <cmath>

#include "mapping/estimation/projection_derivatives.h"

namespace waymark::mapping {
namespace {

struct NormalEquations {
  Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  double cost = 0;  // Huber
  double weighted_squares = 0;
};

class PoseProblem {
 public:
  PoseProblem(const CameraModel& camera, std::span<const Eigen::Vector2d> pixels_px,
              std::span<const Eigen::Vector3d> points_in_world,
              std::span<const std::uint32_t> chosen, double huber_px)
      : camera_(camera),
        pixels_px_(pixels_px),
        points_in_world_(points_in_world),
        chosen_(chosen),
        huber_px_(huber_px) {}

  // nullopt when a point is not in front of the camera.
  std::optional<double> Cost(const Rigid3& world_from_camera) const {
    const Eigen::Matrix3d rotation = world_from_camera.rotation().toRotationMatrix();
    double cost = 0;
    for (std::uint32_t i : chosen_) {
      const Eigen::Vector3d x_in_camera =
          rotation.transpose() * (points_in_world_[i] - world_from_camera.translation());
      if (!(x_in_camera.z() > kMinDepth)) return std::nullopt;
      const Eigen::Vector2d pixel_px = ProjectNormalized<double>(
          camera_.kind(), camera_.parameters().data(), x_in_camera.hnormalized());
      cost += HuberCost((pixel_px - pixels_px_[i]).norm());
    }
    return cost;
  }

  std::optional<NormalEquations> Linearise(const Rigid3& world_from_camera) const {
    const Eigen::Matrix3d rotation = world_from_camera.rotation().toRotationMatrix();
    NormalEquations out;
    for (std::uint32_t i : chosen_) {
      const Eigen::Vector3d offset = points_in_world_[i] - world_from_camera.translation();
      const Eigen::Vector3d x_in_camera = rotation.transpose() * offset;
      if (!(x_in_camera.z() > kMinDepth)) return std::nullopt;
      const ProjectionWithDerivatives projection = ProjectWithDerivatives(
          camera_.kind(), camera_.parameters().data(), x_in_camera.hnormalized());
      const Eigen::Vector2d residual = projection.pixel_px - pixels_px_[i];
      const double length = residual.norm();
      const double weight = length <= huber_px_ ? 1 : huber_px_ / length;
      // x_in_camera = R^T (X - t); under Perturb it moves by R^T (-dt + [X - t]x dr).
      const Eigen::Matrix<double, 2, 3> by_point =
          projection.by_normalized * NormalizationDerivative(x_in_camera) * rotation.transpose();
      Eigen::Matrix<double, 2, 6> jacobian;
      jacobian << -by_point, by_point * CrossMatrix(offset);
      out.matrix.noalias() += weight * jacobian.transpose() * jacobian;
      out.gradient.noalias() += weight * jacobian.transpose() * residual;
      out.cost += HuberCost(length);
      out.weighted_squares += weight * length * length;
    }
    return out;
  }

 private:
  static constexpr double kMinDepth = 1e-9;

  double HuberCost(double length) const {
    return length <= huber_px_ ? length * length : huber_px_ * (2 * length - huber_px_);
  }

  const CameraModel& camera_;
  std::span<const Eigen::Vector2d> pixels_px_;
  std::span<const Eigen::Vector3d> points_in_world_;
  std::span<const std::uint32_t> chosen_;
  double huber_px_;
};

}  // namespace

std::optional<RefinedPose> RefinePose(const CameraModel& camera,
                                      std::span<const Eigen::Vector2d> pixels_px,
                                      std::span<const Eigen::Vector3d> points_in_world,
                                      std::span<const std::uint32_t> chosen,
                                      const Rigid3& world_from_camera,
                                      const PoseRefinementOptions& options) {
  const PoseProblem problem(camera, pixels_px, points_in_world, chosen, options.huber_px);
  Rigid3 pose = world_from_camera;
  auto equations = problem.Linearise(pose);
  if (!equations) return std::nullopt;
  double damping = 1e-6;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    Eigen::Matrix<double, 6, 6> damped = equations->matrix;
    damped.diagonal() *= 1 + damping;
    const Eigen::Matrix<double, 6, 1> step = damped.ldlt().solve(-equations->gradient);
    if (!step.allFinite()) return std::nullopt;
    const Rigid3 candidate = Perturb(pose, step);
    const auto cost = problem.Cost(candidate);
    if (!cost || !(*cost <= equations->cost)) {
      damping = std::max(damping * 10, 1e-4);
      if (damping > 1e6) break;
      continue;
    }
    const double gain = equations->cost - *cost;
    pose = candidate;
    damping = std::max(damping * 0.1, 1e-9);
    const double previous = equations->cost;
    equations = problem.Linearise(pose);
    if (!equations) return std::nullopt;
    if (gain <= 1e-9 * previous) break;
  }
  return RefinedPose{pose, equations->matrix, equations->weighted_squares};
}

}  // namespace waymark::mapping
