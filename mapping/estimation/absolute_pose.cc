// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/absolute_pose.h"

#include <cmath>
#include <utility>

#include "mapping/estimation/internal/pose_from_matches.h"
#include "mapping/estimation/pose_refinement.h"
#include "mapping/estimation/pose_statistics.h"
#include "mapping/estimation/robust_loop.h"

namespace waymark::mapping {
namespace {

double SigmaPx(const CameraModel& camera, std::span<const Eigen::Vector2d> pixels_px,
               std::span<const Eigen::Vector3d> points_in_world,
               std::span<const std::uint32_t> chosen, const Rigid3& world_from_camera) {
  const Rigid3 camera_from_world = world_from_camera.Inverse();
  std::vector<double> errors;
  errors.reserve(chosen.size());
  for (std::uint32_t i : chosen) {
    const auto pixel_px = camera.Project(camera_from_world * points_in_world[i]);
    errors.push_back(pixel_px ? (*pixel_px - pixels_px[i]).norm() : 1e9);
  }
  return RobustSigmaPx(std::move(errors));
}

// Another focal length is taken only where it explains the matches much better.
std::optional<RefinedPose> RefineWithDoubtfulFocal(const CameraModel& camera,
                                                   std::span<const Eigen::Vector2d> pixels_px,
                                                   std::span<const Eigen::Vector3d> points_in_world,
                                                   std::span<const std::uint32_t> inliers,
                                                   const Rigid3& world_from_camera, double sigma_px,
                                                   double focal_sigma_share) {
  PoseRefinementOptions options{.huber_px = kHuberSigmas * sigma_px, .pixel_sigma_px = sigma_px};
  const auto stated =
      RefinePose(camera, pixels_px, points_in_world, inliers, world_from_camera, options);
  if (!stated || focal_sigma_share == 0) return stated;
  options.focal_sigma_share = focal_sigma_share;
  const auto free =
      RefinePose(camera, pixels_px, points_in_world, inliers, stated->world_from_camera, options);
  if (!free || !IsMuchBetter(free->weighted_squares, stated->weighted_squares)) return stated;
  return free;
}

template <typename Problem>
std::optional<AbsolutePose> Estimate(const Problem& problem, const CameraModel& camera,
                                     std::span<const Eigen::Vector2d> pixels_px,
                                     std::span<const Eigen::Vector3d> points_in_world,
                                     std::span<const double> quality,
                                     const AbsolutePoseOptions& options) {
  const std::optional<AbsolutePose> none;
  const auto fit = RunRobustLoop(problem, quality,
                                 {.min_inliers = static_cast<std::size_t>(options.min_inliers),
                                  .confidence = options.confidence,
                                  .max_iterations = DrawsWorthMaking(
                                      pixels_px.size(), Problem::kSampleSize, options.min_inliers,
                                      options.confidence, options.max_iterations),
                                  .seed = options.seed});
  if (!fit) return none;

  AbsolutePose pose{.world_from_camera = fit->model,
                    .inliers = fit->inliers,
                    .covariance = {},
                    .iterations = fit->iterations};
  CameraModel refined_camera = camera;
  std::optional<RefinedPose> refined;
  for (int round = 0; round < kRefinementRounds; ++round) {
    const double sigma_px =
        SigmaPx(refined_camera, pixels_px, points_in_world, pose.inliers, pose.world_from_camera);
    refined = RefineWithDoubtfulFocal(camera, pixels_px, points_in_world, pose.inliers,
                                      pose.world_from_camera, sigma_px, options.focal_sigma_share);
    if (!refined) return none;
    pose.world_from_camera = refined->world_from_camera;
    pose.focal_factor = refined->focal_factor;
    refined_camera = camera.WithScaledFocal(pose.focal_factor);
    const std::vector<std::uint32_t> before = pose.inliers;
    problem.CollectInliers(refined_camera, pose.world_from_camera, 1.0, pose.inliers);
    if (pose.inliers.size() < static_cast<std::size_t>(options.min_inliers)) return none;
    if (pose.inliers == before) break;
  }
  const Rigid3 camera_from_world = pose.world_from_camera.Inverse();
  double squares = 0;
  for (std::uint32_t i : pose.inliers) {
    squares += (*refined_camera.Project(camera_from_world * points_in_world[i]) - pixels_px[i])
                   .squaredNorm();
  }
  pose.rms_px = std::sqrt(squares / static_cast<double>(pose.inliers.size()));
  const auto covariance = PoseCovariance(refined->information, squares, pose.inliers.size());
  if (!covariance) return none;
  pose.covariance = *covariance;
  return pose;
}

}  // namespace

Result<void> AbsolutePoseOptions::Validate() const {
  if (!(max_error_px > 0) || min_inliers < 4 || !(confidence > 0 && confidence < 1) ||
      max_iterations < 1 || !(focal_sigma_share >= 0)) {
    return MakeError(
        ErrorCode::kInvalidArgument,
        "absolute pose: expected max_error_px > 0, min_inliers >= 4, confidence in "
        "(0, 1), max_iterations >= 1, focal_sigma_share >= 0; found {}, {}, {}, {}, {}",
        max_error_px, min_inliers, confidence, max_iterations, focal_sigma_share);
  }
  return {};
}

Result<std::optional<AbsolutePose>> EstimateAbsolutePose(
    const CameraModel& camera, std::span<const Eigen::Vector2d> pixels_px,
    std::span<const Eigen::Vector3d> points_in_world, std::span<const double> quality,
    const AbsolutePoseOptions& options) {
  WAYMARK_TRY(options.Validate());
  if (pixels_px.size() != points_in_world.size() ||
      (!quality.empty() && quality.size() != pixels_px.size())) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "absolute pose: expected as many points and qualities as the {} pixels, "
                     "found {} and {}",
                     pixels_px.size(), points_in_world.size(), quality.size());
  }
  if (pixels_px.size() < static_cast<std::size_t>(options.min_inliers)) {
    return std::optional<AbsolutePose>();
  }
  if (options.up) {
    return Estimate(internal::UprightPoseFromMatches(camera, pixels_px, points_in_world,
                                                     options.max_error_px, *options.up),
                    camera, pixels_px, points_in_world, quality, options);
  }
  return Estimate(
      internal::PoseFromMatches(camera, pixels_px, points_in_world, options.max_error_px), camera,
      pixels_px, points_in_world, quality, options);
}

}  // namespace waymark::mapping
