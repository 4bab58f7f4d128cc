// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/burst/pose.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "localiser/internal/burst/problem.h"
#include "localiser/internal/burst/refinement.h"
#include "mapping/estimation/pose_statistics.h"
#include "mapping/estimation/robust_loop.h"

namespace waymark::localiser::internal {
namespace {

using mapping::AbsolutePose;

constexpr double kConfidence = 0.9999;  // of the robust loop's draws

/// Robust, of the chosen matches.
double SigmaPx(std::span<const BurstCamera> cameras, const ImageMatches& matches,
               std::span<const std::uint32_t> chosen, const BurstState& state) {
  std::vector<double> errors_px;
  for (const std::uint32_t i : chosen) {
    const auto residual_px = BurstResidualPx(cameras, matches, i, state);
    errors_px.push_back(residual_px ? residual_px->norm() : 1e9);
  }
  return mapping::RobustSigmaPx(std::move(errors_px));
}

// Another focal length is taken only where it explains the matches much better, as for one image.
std::optional<RefinedBurst> RefineWithDoubtfulFocal(std::span<const BurstCamera> cameras,
                                                    const ImageMatches& matches,
                                                    std::span<const std::uint32_t> chosen,
                                                    const BurstState& start,
                                                    const BurstPoseOptions& options) {
  const double sigma_px = SigmaPx(cameras, matches, chosen, start);
  BurstRefinementOptions refining{.huber_px = mapping::kHuberSigmas * sigma_px,
                                  .scale_sigma_share = options.scale_sigma_share,
                                  .pixel_sigma_px = sigma_px};
  BurstState as_stated = start;
  as_stated.focal_factor = 1;
  const auto stated = RefineBurst(cameras, matches, chosen, as_stated, refining);
  if (!stated || options.focal_sigma_share == 0) return stated;
  refining.focal_sigma_share = options.focal_sigma_share;
  auto free = RefineBurst(cameras, matches, chosen, stated->state, refining);
  const bool is_free_better =
      free && mapping::IsMuchBetter(free->weighted_squares, stated->weighted_squares);
  return is_free_better ? free : stated;
}

/// Repeats refinement and the choice of inliers until they stay. nullopt: too few are left.
std::optional<RefinedBurst> Polish(std::span<const BurstCamera> cameras,
                                   const ImageMatches& matches, const BurstProblem& problem,
                                   const BurstPoseOptions& options, BurstState state,
                                   std::vector<std::uint32_t>& inliers) {
  std::optional<RefinedBurst> refined;
  for (int round = 0; round < mapping::kRefinementRounds; ++round) {
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

/// Odometry's metre as the matches have it when nothing is believed of it, where that fits them
/// much better; else as refined.
double ScaleOfMatches(std::span<const BurstCamera> cameras, const ImageMatches& matches,
                      std::span<const std::uint32_t> inliers, const RefinedBurst& refined) {
  const double sigma_px = SigmaPx(cameras, matches, inliers, refined.state);
  const auto free = RefineBurst(cameras, matches, inliers, refined.state,
                                {.huber_px = mapping::kHuberSigmas * sigma_px,
                                 .scale_sigma_share = 1,
                                 .pixel_sigma_px = sigma_px});
  const bool is_free_better =
      free && mapping::IsMuchBetter(free->weighted_squares, refined.weighted_squares);
  return is_free_better ? free->state.scale : refined.state.scale;
}

}  // namespace

std::optional<BurstPose> EstimateBurstPose(std::span<const BurstCamera> cameras,
                                           const ImageMatches& matches,
                                           const BurstPoseOptions& options) {
  const auto min_inliers = static_cast<std::size_t>(options.min_inliers);
  if (matches.size() < min_inliers) return std::nullopt;
  const BurstProblem problem(cameras, matches, options.up_in_submap, options.max_error_px);
  auto fit = mapping::RunRobustLoop(problem, matches.quality,
                                    {.min_inliers = min_inliers,
                                     .max_iterations = mapping::DrawsWorthMaking(
                                         matches.size(), BurstProblem::kSampleSize,
                                         options.min_inliers, kConfidence, options.max_draws),
                                     .seed = options.seed});
  if (!fit) return std::nullopt;
  const auto refined = Polish(cameras, matches, problem, options, {fit->model}, fit->inliers);
  if (!refined) return std::nullopt;
  double squares = 0;
  for (const std::uint32_t i : fit->inliers) {
    squares += BurstResidualPx(cameras, matches, i, refined->state)->squaredNorm();
  }
  const std::size_t count = fit->inliers.size();
  const auto covariance = mapping::PoseCovariance(refined->information, squares, count);
  if (!covariance) return std::nullopt;
  const double odometry_scale = ScaleOfMatches(cameras, matches, fit->inliers, *refined);
  return BurstPose{{.world_from_camera = refined->state.submap_from_vo,
                    .focal_factor = refined->state.focal_factor,
                    .inliers = std::move(fit->inliers),
                    .rms_px = std::sqrt(squares / static_cast<double>(count)),
                    .covariance = *covariance,
                    .iterations = fit->iterations},
                   odometry_scale};
}

AbsolutePose PoseOfImage(const AbsolutePose& submap_from_vo, std::span<const BurstCamera> cameras,
                         const ImageMatches& matches, std::size_t image, double drift_share) {
  const Rigid3& vo_from_camera = cameras[image].vo_from_camera;
  AbsolutePose pose = submap_from_vo;
  pose.world_from_camera = submap_from_vo.world_from_camera * vo_from_camera;
  // A shift of odometry's frame shifts its images; a turn moves those far from its origin.
  Eigen::Matrix<double, 6, 6> jacobian = Eigen::Matrix<double, 6, 6>::Identity();
  jacobian.topRightCorner<3, 3>() =
      -CrossMatrix(submap_from_vo.world_from_camera.rotation() * vo_from_camera.translation());
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
