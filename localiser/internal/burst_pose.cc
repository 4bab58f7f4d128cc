// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/burst_pose.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "localiser/internal/burst_problem.h"
#include "localiser/internal/burst_refinement.h"
#include "mapping/base/median.h"
#include "mapping/estimation/robust_loop.h"

namespace waymark::localiser::internal {
namespace {

using mapping::AbsolutePose;

constexpr double kMinPixelSigma = 0.25;  // below this no detector localises

/// Robust, of the chosen matches.
double SigmaPx(std::span<const BurstCamera> cameras, const ImageMatches& matches,
               std::span<const std::uint32_t> chosen, const BurstState& state) {
  constexpr double kMedianLengthOfUnitSigma = 1.177;  // of two normal components
  std::vector<double> errors_px;
  for (const std::uint32_t i : chosen) {
    const auto residual_px = BurstResidualPx(cameras, matches, i, state);
    errors_px.push_back(residual_px ? residual_px->norm() : 1e9);
  }
  return std::max(kMinPixelSigma, Median(std::move(errors_px)) / kMedianLengthOfUnitSigma);
}

// Another focal length is taken only where it explains the matches much better, as for one image.
std::optional<RefinedBurst> RefineWithDoubtfulFocal(std::span<const BurstCamera> cameras,
                                                    const ImageMatches& matches,
                                                    std::span<const std::uint32_t> chosen,
                                                    const BurstState& start,
                                                    const BurstPoseOptions& options) {
  constexpr double kHuberSigmas = 1.345;  // 95 % efficiency
  constexpr double kMuchBetter = 0.8;
  const double sigma_px = SigmaPx(cameras, matches, chosen, start);
  BurstRefinementOptions refining{.huber_px = kHuberSigmas * sigma_px,
                                  .scale_sigma_share = options.scale_sigma_share,
                                  .pixel_sigma_px = sigma_px};
  BurstState as_stated = start;
  as_stated.focal_factor = 1;
  const auto stated = RefineBurst(cameras, matches, chosen, as_stated, refining);
  if (!stated || options.focal_sigma_share == 0) return stated;
  refining.focal_sigma_share = options.focal_sigma_share;
  auto free = RefineBurst(cameras, matches, chosen, stated->state, refining);
  if (!free || free->weighted_squares > kMuchBetter * stated->weighted_squares) return stated;
  return free;
}

// After so many draws a pose with the least inliers asked for would have been found, if there were
// one; twice, because samples carry noise.
int DrawsWorthMaking(std::size_t matches, const BurstPoseOptions& options) {
  constexpr double kLeast = 200;
  constexpr double kConfidence = 0.9999;
  const double share = static_cast<double>(options.min_inliers) / static_cast<double>(matches);
  const double needed = 2 * std::log1p(-kConfidence) / std::log1p(-std::min(share * share, 0.99));
  return std::min(options.max_draws,
                  static_cast<int>(std::clamp(needed, kLeast, double{1} * (1 << 30))));
}

/// Repeats refinement and the choice of inliers until they stay. nullopt: too few are left.
std::optional<RefinedBurst> Polish(std::span<const BurstCamera> cameras,
                                   const ImageMatches& matches, const BurstProblem& problem,
                                   const BurstPoseOptions& options, BurstState state,
                                   std::vector<std::uint32_t>& inliers) {
  constexpr int kRounds = 4;
  std::optional<RefinedBurst> refined;
  for (int round = 0; round < kRounds; ++round) {
    refined = RefineWithDoubtfulFocal(cameras, matches, inliers, state, options);
    if (!refined) return std::nullopt;
    state = refined->state;
    const std::vector<std::uint32_t> before = inliers;
    problem.CollectInliers(state, 1, inliers);
    if (inliers.size() < static_cast<std::size_t>(options.min_inliers)) return std::nullopt;
    if (inliers == before) break;
  }
  return refined;
}

}  // namespace

std::optional<AbsolutePose> EstimateBurstPose(std::span<const BurstCamera> cameras,
                                              const ImageMatches& matches,
                                              const BurstPoseOptions& options) {
  const auto min_inliers = static_cast<std::size_t>(options.min_inliers);
  if (matches.size() < min_inliers) return std::nullopt;
  const BurstProblem problem(cameras, matches, options.up_in_submap, options.max_error_px);
  auto fit = mapping::RunRobustLoop(problem, matches.quality,
                                    {.min_inliers = min_inliers,
                                     .max_iterations = DrawsWorthMaking(matches.size(), options),
                                     .seed = options.seed});
  if (!fit) return std::nullopt;
  const auto refined = Polish(cameras, matches, problem, options, {fit->model}, fit->inliers);
  if (!refined) return std::nullopt;
  double squares = 0;
  for (const std::uint32_t i : fit->inliers) {
    squares += BurstResidualPx(cameras, matches, i, refined->state)->squaredNorm();
  }
  const auto count = static_cast<double>(fit->inliers.size());
  const double variance =
      std::max(kMinPixelSigma * kMinPixelSigma, squares / std::max(1.0, 2 * count - 6));
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> information(refined->information);
  if (!(information.vectorD().minCoeff() > 0)) return std::nullopt;
  AbsolutePose pose{
      .world_from_camera = refined->state.submap_from_vo,
      .focal_factor = refined->state.focal_factor,
      .inliers = std::move(fit->inliers),
      .rms_px = std::sqrt(squares / count),
      .covariance = variance * information.solve(Eigen::Matrix<double, 6, 6>::Identity()),
      .iterations = fit->iterations};
  if (!pose.covariance.allFinite()) return std::nullopt;
  return pose;
}

AbsolutePose PoseOfImage(const AbsolutePose& submap_from_vo, std::span<const BurstCamera> cameras,
                         const ImageMatches& matches, std::size_t image, double drift_share) {
  const Rigid3& vo_from_camera = cameras[image].vo_from_camera;
  AbsolutePose pose = submap_from_vo;
  pose.world_from_camera = submap_from_vo.world_from_camera * vo_from_camera;
  // A shift of odometry's frame shifts its images; a turn moves those far from its origin.
  Eigen::Matrix<double, 6, 6> jacobian = Eigen::Matrix<double, 6, 6>::Identity();
  jacobian.topRightCorner<3, 3>() = -CrossMatrix(submap_from_vo.world_from_camera.rotation() *
                                                 vo_from_camera.translation());
  pose.covariance = jacobian * submap_from_vo.covariance * jacobian.transpose();
  double way = 0;
  for (const std::uint32_t i : pose.inliers) {
    way += (cameras[matches.images[i]].vo_from_camera.translation() - vo_from_camera.translation())
               .norm();
  }
  way /= static_cast<double>(std::max<std::size_t>(1, pose.inliers.size()));
  pose.covariance.diagonal().head<3>().array() += std::pow(drift_share * way, 2);
  return pose;
}

}  // namespace waymark::localiser::internal
