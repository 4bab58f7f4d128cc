// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/pose_refinement.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

#include "mapping/estimation/projection_derivatives.h"

namespace waymark::mapping {
namespace {

// The pose and the logarithm of the focal length's factor.
struct State {
  Rigid3 world_from_camera;
  double log_focal = 0;
};

struct NormalEquations {
  Eigen::Matrix<double, 7, 7> matrix = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, 1> gradient = Eigen::Matrix<double, 7, 1>::Zero();
  double cost = 0;  // Huber
  double weighted_squares = 0;
};

class PoseProblem {
 public:
  PoseProblem(const CameraModel& camera, std::span<const Eigen::Vector2d> pixels_px,
              std::span<const Eigen::Vector3d> points_in_world,
              std::span<const std::uint32_t> chosen, const PoseRefinementOptions& options)
      : camera_(camera),
        pixels_px_(pixels_px),
        points_in_world_(points_in_world),
        chosen_(chosen),
        huber_px_(options.huber_px),
        centre_px_(camera.PrincipalPoint()) {
    if (options.focal_sigma_share > 0) {
      const double share = options.pixel_sigma_px / options.focal_sigma_share;
      focal_weight_ = share * share;
    }
  }

  // nullopt when a point is not in front of the camera.
  std::optional<double> Cost(const State& state) const {
    const Eigen::Matrix3d rotation = state.world_from_camera.rotation().toRotationMatrix();
    const double focal_factor = std::exp(state.log_focal);
    double cost = PriorCost(state);
    for (std::uint32_t i : chosen_) {
      const Eigen::Vector3d x_in_camera =
          rotation.transpose() * (points_in_world_[i] - state.world_from_camera.translation());
      if (!(x_in_camera.z() > kMinDepth)) return std::nullopt;
      const Eigen::Vector2d pixel_px = ProjectNormalized<double>(
          camera_.kind(), camera_.parameters().data(), x_in_camera.hnormalized());
      cost += HuberCost(Residual(pixel_px, focal_factor, i).norm());
    }
    return cost;
  }

  std::optional<NormalEquations> Linearise(const State& state) const {
    const Eigen::Matrix3d rotation = state.world_from_camera.rotation().toRotationMatrix();
    const double focal_factor = std::exp(state.log_focal);
    NormalEquations out;
    out.cost = PriorCost(state);
    for (std::uint32_t i : chosen_) {
      const Eigen::Vector3d offset = points_in_world_[i] - state.world_from_camera.translation();
      const Eigen::Vector3d x_in_camera = rotation.transpose() * offset;
      if (!(x_in_camera.z() > kMinDepth)) return std::nullopt;
      const ProjectionWithDerivatives projection = ProjectWithDerivatives(
          camera_.kind(), camera_.parameters().data(), x_in_camera.hnormalized());
      const Eigen::Vector2d residual = Residual(projection.pixel_px, focal_factor, i);
      const double length = residual.norm();
      const double weight = length <= huber_px_ ? 1 : huber_px_ / length;
      // x_in_camera = R^T (X - t); under Perturb it moves by R^T (-dt + [X - t]x dr).
      const Eigen::Matrix<double, 2, 3> by_point = focal_factor * projection.by_normalized *
                                                   NormalizationDerivative(x_in_camera) *
                                                   rotation.transpose();
      Eigen::Matrix<double, 2, 7> jacobian;
      jacobian << -by_point, by_point * CrossMatrix(offset),
          focal_factor * (projection.pixel_px - centre_px_);
      out.matrix.noalias() += weight * jacobian.transpose() * jacobian;
      out.gradient.noalias() += weight * jacobian.transpose() * residual;
      out.cost += HuberCost(length);
      out.weighted_squares += weight * length * length;
    }
    AddPrior(state, out);
    return out;
  }

 private:
  static constexpr double kMinDepth = 1e-9;

  Eigen::Vector2d Residual(const Eigen::Vector2d& pixel_px, double focal_factor,
                           std::uint32_t i) const {
    return centre_px_ + focal_factor * (pixel_px - centre_px_) - pixels_px_[i];
  }

  double PriorCost(const State& state) const {
    return focal_weight_ ? *focal_weight_ * state.log_focal * state.log_focal : 0;
  }

  void AddPrior(const State& state, NormalEquations& out) const {
    if (focal_weight_) {
      out.matrix(6, 6) += *focal_weight_;
      out.gradient(6) += *focal_weight_ * state.log_focal;
    } else {
      out.matrix.row(6).setZero();
      out.matrix.col(6).setZero();
      out.matrix(6, 6) = 1;
      out.gradient(6) = 0;
    }
  }

  double HuberCost(double length) const {
    return length <= huber_px_ ? length * length : huber_px_ * (2 * length - huber_px_);
  }

  const CameraModel& camera_;
  std::span<const Eigen::Vector2d> pixels_px_;
  std::span<const Eigen::Vector3d> points_in_world_;
  std::span<const std::uint32_t> chosen_;
  double huber_px_;
  Eigen::Vector2d centre_px_;
  std::optional<double> focal_weight_;  // absent: the focal length is exact
};

}  // namespace

std::optional<RefinedPose> RefinePose(const CameraModel& camera,
                                      std::span<const Eigen::Vector2d> pixels_px,
                                      std::span<const Eigen::Vector3d> points_in_world,
                                      std::span<const std::uint32_t> chosen,
                                      const Rigid3& world_from_camera,
                                      const PoseRefinementOptions& options) {
  const PoseProblem problem(camera, pixels_px, points_in_world, chosen, options);
  State state{world_from_camera};
  auto equations = problem.Linearise(state);
  if (!equations) return std::nullopt;
  constexpr double kMaxFocalStep = 0.1;
  double damping = 1e-6;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    Eigen::Matrix<double, 7, 7> damped = equations->matrix;
    damped.diagonal() *= 1 + damping;
    const Eigen::Matrix<double, 7, 1> step = damped.ldlt().solve(-equations->gradient);
    if (!step.allFinite()) return std::nullopt;
    const State candidate{Perturb(state.world_from_camera, step.head<6>()),
                          state.log_focal + std::clamp(step(6), -kMaxFocalStep, kMaxFocalStep)};
    const auto cost = problem.Cost(candidate);
    if (!cost || !(*cost <= equations->cost)) {
      damping = std::max(damping * 10, 1e-4);
      if (damping > 1e6) break;
      continue;
    }
    const double gain = equations->cost - *cost;
    state = candidate;
    damping = std::max(damping * 0.1, 1e-9);
    const double previous = equations->cost;
    equations = problem.Linearise(state);
    if (!equations) return std::nullopt;
    if (gain <= 1e-9 * previous) break;
  }
  // What is left for the pose once the focal length is marginalised.
  const auto& matrix = equations->matrix;
  const Eigen::Matrix<double, 6, 1> coupling = matrix.topRightCorner<6, 1>();
  return RefinedPose{state.world_from_camera, std::exp(state.log_focal),
                     matrix.topLeftCorner<6, 6>() - coupling * coupling.transpose() / matrix(6, 6),
                     equations->weighted_squares};
}

}  // namespace waymark::mapping
