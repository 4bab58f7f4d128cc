// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/burst/refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

#include "mapping/estimation/projection_derivatives.h"

namespace waymark::localiser::internal {
namespace {

// The pose, and the logarithms of the focal factor and of the scale.
using Vector8 = Eigen::Matrix<double, 8, 1>;
using Matrix8 = Eigen::Matrix<double, 8, 8>;

constexpr int kFocal = 6;
constexpr int kScale = 7;

constexpr double kMinDepth = 1e-9;

struct NormalEquations {
  Matrix8 matrix = Matrix8::Zero();
  Vector8 gradient = Vector8::Zero();
  double cost = 0;  // Huber
  double weighted_squares = 0;
};

class RefinementProblem {
 public:
  RefinementProblem(std::span<const BurstCamera> cameras, const ImageMatches& matches,
                    std::span<const std::uint32_t> chosen, const BurstRefinementOptions& options)
      : cameras_(cameras), matches_(matches), chosen_(chosen), huber_px_(options.huber_px) {
    for (const BurstCamera& taken : cameras) {
      camera_from_vo_.push_back(taken.vo_from_camera.rotation().toRotationMatrix().transpose());
    }
    focal_weight_ = WeightOf(options.focal_sigma_share, options.pixel_sigma_px);
    scale_weight_ = WeightOf(options.scale_sigma_share, options.pixel_sigma_px);
  }

  // nullopt when a point is not in front of its camera.
  std::optional<NormalEquations> Linearise(const BurstState& state) const {
    const Eigen::Matrix3d vo_from_submap =
        state.submap_from_vo.rotation().toRotationMatrix().transpose();
    NormalEquations out;
    for (const std::uint32_t i : chosen_) {
      const std::uint32_t image = matches_.images[i];
      const CameraModel& camera = cameras_[image].camera;
      const Eigen::Vector3d offset =
          matches_.points_in_submap[i] - state.submap_from_vo.translation();
      const Eigen::Vector3d centre_in_vo =
          state.scale * cameras_[image].vo_from_camera.translation();
      const Eigen::Vector3d x_in_camera =
          camera_from_vo_[image] * (vo_from_submap * offset - centre_in_vo);
      if (!(x_in_camera.z() > kMinDepth)) return std::nullopt;
      const auto projection = mapping::ProjectWithDerivatives(
          camera.kind(), camera.parameters().data(), x_in_camera.hnormalized());
      const Eigen::Vector2d from_centre_px = projection.pixel_px - camera.PrincipalPoint();
      const Eigen::Vector2d residual =
          camera.PrincipalPoint() + state.focal_factor * from_centre_px - matches_.pixels_px[i];
      // Under Perturb the point moves by R^T (-dt + [X - t]x dr) in odometry's frame.
      const Eigen::Matrix<double, 2, 3> by_vo = state.focal_factor * projection.by_normalized *
                                                mapping::NormalizationDerivative(x_in_camera) *
                                                camera_from_vo_[image];
      const Eigen::Matrix<double, 2, 3> by_point = by_vo * vo_from_submap;
      Eigen::Matrix<double, 2, 8> jacobian;
      jacobian << -by_point, by_point * CrossMatrix(offset), state.focal_factor * from_centre_px,
          -by_vo * centre_in_vo;
      Add(jacobian, residual, out);
    }
    AddPriors(state, out);
    return out;
  }

 private:
  void Add(const Eigen::Matrix<double, 2, 8>& jacobian, const Eigen::Vector2d& residual,
           NormalEquations& out) const {
    const double length = residual.norm();
    const double weight = length <= huber_px_ ? 1 : huber_px_ / length;
    out.matrix.noalias() += weight * jacobian.transpose() * jacobian;
    out.gradient.noalias() += weight * jacobian.transpose() * residual;
    out.cost += length <= huber_px_ ? length * length : huber_px_ * (2 * length - huber_px_);
    out.weighted_squares += weight * length * length;
  }

  static std::optional<double> WeightOf(double sigma_share, double pixel_sigma_px) {
    if (!(sigma_share > 0)) return std::nullopt;
    return std::pow(pixel_sigma_px / sigma_share, 2);
  }

  void AddPriors(const BurstState& state, NormalEquations& out) const {
    AddPrior(kFocal, std::log(state.focal_factor), focal_weight_, out);
    AddPrior(kScale, std::log(state.scale), scale_weight_, out);
  }

  static void AddPrior(int unknown, double value, const std::optional<double>& weight,
                       NormalEquations& out) {
    if (weight) {
      out.matrix(unknown, unknown) += *weight;
      out.gradient(unknown) += *weight * value;
      out.cost += *weight * value * value;
      return;
    }
    out.matrix.row(unknown).setZero();
    out.matrix.col(unknown).setZero();
    out.matrix(unknown, unknown) = 1;
    out.gradient(unknown) = 0;
  }

  std::span<const BurstCamera> cameras_;
  const ImageMatches& matches_;
  std::span<const std::uint32_t> chosen_;
  double huber_px_;
  std::vector<Eigen::Matrix3d> camera_from_vo_;
  std::optional<double> focal_weight_, scale_weight_;  // absent: exact
};

}  // namespace

std::optional<RefinedBurst> RefineBurst(std::span<const BurstCamera> cameras,
                                        const ImageMatches& matches,
                                        std::span<const std::uint32_t> chosen,
                                        const BurstState& start,
                                        const BurstRefinementOptions& options) {
  constexpr double kMaxStep = 0.1;  // of the logarithms
  constexpr double kMaxDamping = 1e6;
  const RefinementProblem problem(cameras, matches, chosen, options);
  BurstState state = start;
  auto equations = problem.Linearise(state);
  if (!equations) return std::nullopt;
  double damping = 1e-6;
  for (int i = 0; i < options.max_iterations && damping <= kMaxDamping; ++i) {
    Matrix8 damped = equations->matrix;
    damped.diagonal() *= 1 + damping;
    const Vector8 step = damped.ldlt().solve(-equations->gradient);
    if (!step.allFinite()) return std::nullopt;
    const auto moved = [&](double value, int unknown) {
      return value * std::exp(std::clamp(step(unknown), -kMaxStep, kMaxStep));
    };
    const BurstState candidate{Perturb(state.submap_from_vo, step.head<6>()),
                               moved(state.focal_factor, kFocal), moved(state.scale, kScale)};
    auto there = problem.Linearise(candidate);
    if (!there || !(there->cost <= equations->cost)) {
      damping = std::max(damping * 10, 1e-4);
      continue;
    }
    const double gain = equations->cost - there->cost;
    const double before = equations->cost;
    state = candidate;
    damping = std::max(damping * 0.1, 1e-9);
    equations = std::move(there);
    if (gain <= 1e-9 * before) break;
  }
  // What is left for the pose once focal factor and scale are marginalised.
  const Eigen::Matrix<double, 6, 2> coupling = equations->matrix.topRightCorner<6, 2>();
  const Eigen::Matrix2d rest = equations->matrix.bottomRightCorner<2, 2>();
  return RefinedBurst{
      state,
      equations->matrix.topLeftCorner<6, 6>() - coupling * rest.inverse() * coupling.transpose(),
      equations->weighted_squares};
}

std::optional<Eigen::Vector2d> BurstResidualPx(std::span<const BurstCamera> cameras,
                                               const ImageMatches& matches, std::uint32_t match,
                                               const BurstState& state) {
  const BurstCamera& taken = cameras[matches.images[match]];
  const Rigid3 vo_from_camera(taken.vo_from_camera.rotation(),
                              state.scale * taken.vo_from_camera.translation());
  const Rigid3 camera_from_submap = (state.submap_from_vo * vo_from_camera).Inverse();
  const auto pixel_px = taken.camera.Project(camera_from_submap * matches.points_in_submap[match]);
  if (!pixel_px) return std::nullopt;
  const Eigen::Vector2d centre_px = taken.camera.PrincipalPoint();
  return Eigen::Vector2d(centre_px + state.focal_factor * (*pixel_px - centre_px) -
                         matches.pixels_px[match]);
}

}  // namespace waymark::localiser::internal
