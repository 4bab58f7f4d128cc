// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/geo_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "mapping/estimation/up_direction.h"

namespace waymark::mapping {
namespace {

class Alignment {
 public:
  Alignment(std::span<const GeoSample> samples, const GeoAlignmentOptions& options)
      : samples_(samples), options_(options), upright_(Eigen::Quaterniond::Identity()) {
    const Eigen::Vector3d up = EstimateUp(samples);
    upright_ = UprightRotation(up);
    gravity_sigma_rad_ = EstimateGravitySigma(samples, up, options.gravity_sigma_rad);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (samples[i].position_in_enu) placed_.push_back(static_cast<std::uint32_t>(i));
      has_gravity_ = has_gravity_ || samples[i].up_in_camera.has_value();
    }
  }

  std::span<const std::uint32_t> placed() const { return placed_; }

  // Neither accelerometers nor level axes tell upside down apart once an optimisation has begun.
  bool IsUpright(const Sim3& enu_from_model) const {
    const double cosine =
        (enu_from_model.rotation() * (upright_.conjugate() * Eigen::Vector3d::UnitZ())).z();
    // Without gravity cameras may be held in portrait: their y axis says little.
    return cosine > (has_gravity_ ? 0.7 : -0.3);
  }

  double PositionError(const Sim3& enu_from_model, std::uint32_t i) const {
    const GeoSample& sample = samples_[i];
    return (enu_from_model * sample.model_from_camera.translation() - *sample.position_in_enu)
               .norm() /
           sample.position_sigma_m;
  }

  // Positions and accelerometers: along a straight street, positions let the model roll freely.
  double Cost(const Sim3& enu_from_model) const {
    double cost = 0;
    const auto add = [&](double error_sigmas) {
      const double share = error_sigmas / options_.max_error_sigmas;
      cost += std::min(share * share, 1.0);
    };
    for (std::uint32_t i : placed_) add(PositionError(enu_from_model, i));
    for (const GeoSample& sample : samples_) {
      if (!sample.up_in_camera) continue;
      const Eigen::Vector3d up = enu_from_model.rotation() * sample.UpInModel();
      add(std::atan2(up.head<2>().norm(), up.z()) / gravity_sigma_rad_);
    }
    return cost;
  }

  // Yaw, scale and translation from two positions, tilt from the up direction.
  std::optional<Sim3> FromPair(std::uint32_t i, std::uint32_t j) const {
    const Eigen::Vector3d from_i = upright_ * samples_[i].model_from_camera.translation();
    const Eigen::Vector3d from_j = upright_ * samples_[j].model_from_camera.translation();
    const Eigen::Vector3d& to_i = *samples_[i].position_in_enu;
    const Eigen::Vector3d& to_j = *samples_[j].position_in_enu;
    const Eigen::Vector2d from = (from_j - from_i).head<2>();
    const Eigen::Vector2d to = (to_j - to_i).head<2>();
    if (!(from.norm() > 1e-9) || !(to.norm() > 1e-9)) return std::nullopt;
    const double yaw = std::atan2(to.y(), to.x()) - std::atan2(from.y(), from.x());
    const double scale = to.norm() / from.norm();
    const Eigen::Quaterniond rotation = RotationFromVector({0, 0, yaw}) * upright_;
    const Eigen::Vector3d middle = 0.5 * (samples_[i].model_from_camera.translation() +
                                          samples_[j].model_from_camera.translation());
    return Sim3(scale, rotation, 0.5 * (to_i + to_j) - scale * (rotation * middle));
  }

  // Gauss-Newton on positions (Cauchy) and up directions, over all seven degrees of freedom.
  Sim3 Refine(const Sim3& start) const {
    constexpr int kIterations = 20;
    Sim3 sim = start;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      normal_.setZero();
      gradient_.setZero();
      for (std::uint32_t i : placed_) AddPosition(sim, samples_[i]);
      for (const GeoSample& sample : samples_) AddUp(sim, sample);
      normal_.diagonal().array() += 1e-9;
      const Eigen::Matrix<double, 7, 1> step = normal_.ldlt().solve(-gradient_);
      if (!step.allFinite()) return start;
      sim = Sim3(sim.scale() * std::exp(std::clamp(step(6), -0.5, 0.5)),
                 RotationFromVector(step.segment<3>(3)) * sim.rotation(),
                 sim.translation() + step.head<3>());
      if (step.norm() < 1e-10) break;
    }
    return sim;
  }

 private:
  template <int kRows>
  void Add(const Eigen::Matrix<double, kRows, 1>& residual,
           const Eigen::Matrix<double, kRows, 7>& jacobian, double scale) const {
    const double weight = 1 / (1 + residual.squaredNorm() / (scale * scale));
    normal_.noalias() += weight * jacobian.transpose() * jacobian;
    gradient_.noalias() += weight * jacobian.transpose() * residual;
  }

  void AddPosition(const Sim3& sim, const GeoSample& sample) const {
    const double weight = 1 / sample.position_sigma_m;
    const Eigen::Vector3d turned =
        sim.scale() * (sim.rotation() * sample.model_from_camera.translation());
    const Eigen::Vector3d residual =
        weight * (turned + sim.translation() - *sample.position_in_enu);
    Eigen::Matrix<double, 3, 7> jacobian;
    jacobian << Eigen::Matrix3d::Identity(), -CrossMatrix(turned), turned;
    Add<3>(residual, weight * jacobian, options_.max_error_sigmas);
  }

  void AddUp(const Sim3& sim, const GeoSample& sample) const {
    if (sample.up_in_camera) {
      const Eigen::Vector3d up = sim.rotation() * sample.UpInModel();
      const double weight = 1 / gravity_sigma_rad_;
      Eigen::Matrix<double, 2, 7> jacobian = Eigen::Matrix<double, 2, 7>::Zero();
      jacobian.middleCols<3>(3) = -weight * CrossMatrix(up).topRows<2>();
      Add<2>(weight * up.head<2>(), jacobian, 3);
    } else if (!has_gravity_) {
      const Eigen::Vector3d x_axis = sim.rotation() * sample.XAxisInModel();
      const double weight = 1 / options_.level_sigma_rad;
      Eigen::Matrix<double, 1, 7> jacobian = Eigen::Matrix<double, 1, 7>::Zero();
      jacobian.middleCols<3>(3) = -weight * CrossMatrix(x_axis).row(2);
      Add<1>(Eigen::Matrix<double, 1, 1>(weight * x_axis.z()), jacobian, 1);
    }
  }

  std::span<const GeoSample> samples_;
  const GeoAlignmentOptions& options_;
  Eigen::Quaterniond upright_;
  std::vector<std::uint32_t> placed_;
  bool has_gravity_ = false;
  double gravity_sigma_rad_ = 1;
  mutable Eigen::Matrix<double, 7, 7> normal_;  // scratch of Refine
  mutable Eigen::Matrix<double, 7, 1> gradient_;
};

// Standard deviations of positions along their principal axes, largest last.
Eigen::Vector3d Spread(std::span<const Eigen::Vector3d> positions) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : positions) mean += p / static_cast<double>(positions.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : positions) covariance += (p - mean) * (p - mean).transpose();
  covariance /= static_cast<double>(positions.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
}

}  // namespace

std::optional<GeoAlignment> EstimateGeoAlignment(std::span<const GeoSample> samples,
                                                 const GeoAlignmentOptions& options) {
  const Alignment alignment(samples, options);
  const std::span<const std::uint32_t> placed = alignment.placed();
  if (placed.size() < 3) return std::nullopt;

  constexpr int kHypotheses = 300;
  std::mt19937_64 engine(options.seed);
  const auto draw = [&] { return placed[(engine() >> 32) * placed.size() >> 32]; };
  std::optional<Sim3> best;
  double best_cost = std::numeric_limits<double>::infinity();
  const auto consider = [&](const std::optional<Sim3>& sim) {
    if (!sim || !alignment.IsUpright(*sim)) return;
    const double cost = alignment.Cost(*sim);
    if (!(cost < best_cost)) return;
    best = sim;
    best_cost = cost;
  };
  for (int k = 0; k < kHypotheses; ++k) {
    const std::uint32_t i = draw();
    const std::uint32_t j = draw();
    const std::uint32_t l = draw();
    consider(alignment.FromPair(i, j));
    if (i == j || j == l || i == l) continue;
    const std::array from{samples[i].model_from_camera.translation(),
                          samples[j].model_from_camera.translation(),
                          samples[l].model_from_camera.translation()};
    const std::array to{*samples[i].position_in_enu, *samples[j].position_in_enu,
                        *samples[l].position_in_enu};
    if (const auto sim = EstimateSimilarity(from, to)) consider(*sim);
  }
  if (!best) return std::nullopt;
  const Sim3 refined = alignment.Refine(*best);
  if (alignment.Cost(refined) <= best_cost) best = refined;

  GeoAlignment result{.enu_from_model = *best, .inliers = {}};
  std::vector<Eigen::Vector3d> positions;
  double mean_sigma_m = 0;
  for (std::uint32_t i : placed) {
    if (alignment.PositionError(*best, i) >= options.max_error_sigmas) continue;
    result.inliers.push_back(i);
    positions.push_back(*best * samples[i].model_from_camera.translation());
    mean_sigma_m += samples[i].position_sigma_m;
  }
  if (positions.size() < 3) return std::nullopt;
  const auto count = static_cast<double>(positions.size());
  mean_sigma_m /= count;
  const Eigen::Vector3d spread = Spread(positions);
  if (!(mean_sigma_m / (spread(2) * std::sqrt(count)) < options.max_scale_error)) {
    return std::nullopt;
  }
  result.is_straight = mean_sigma_m / (spread(1) * std::sqrt(count)) > 0.1;
  return result;
}

}  // namespace waymark::mapping
