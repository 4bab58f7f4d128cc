// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/burst/candidates.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "localiser/internal/burst/evidence.h"
#include "localiser/internal/pose_acceptance.h"
#include "localiser/internal/stated_covariance.h"
#include "mapping/base/stopwatch.h"

namespace waymark::localiser::internal {
namespace {

constexpr double kDriftShare = 0.02;  // of the way between images, what odometry is good to

SubmapAnswer FindMatches(const OpenSubmap& submap, const AskedBurst& burst,
                         std::span<const RankedCells> cells) {
  SubmapAnswer all;
  std::uint32_t features_before = 0;
  for (std::uint32_t i = 0; i < burst.images.size(); ++i) {
    const SubmapAnswer own = submap.localiser().FindMatches(burst.features[i], cells[i]);
    for (std::size_t k = 0; k < own.matches.size(); ++k) all.matches.Add(own.matches, k, i);
    for (Resemblance found : own.resemblances) {
      found.feature += features_before;
      all.resemblances.push_back(found);
    }
    features_before += static_cast<std::uint32_t>(burst.features[i].keypoints.size());
    all.search_ms += own.search_ms;
  }
  return all;
}

// Sightings of one landmark share its error.
void InflateForRepetition(const BurstEvidence& evidence, mapping::AbsolutePose& pose) {
  pose.covariance *=
      static_cast<double>(pose.inliers.size()) / static_cast<double>(evidence.landmarks());
}

/// What the pose rests on; nullopt: there is none, or it is refused.
std::optional<BurstEvidence> EstimatePose(const OpenSubmap& submap, const AskedBurst& burst,
                                          const LocaliserOptions& options, SubmapAnswer& answer) {
  const std::vector<BurstCamera> cameras = CamerasIn(submap, burst);
  const auto submap_from_vo =
      EstimateBurstPose(cameras, answer.matches, BurstPoseOptionsIn(submap, options));
  if (!submap_from_vo) {
    answer.refusal = fmt::format("no pose agrees with {} of {} matches of {} images",
                                 options.min_inliers, answer.matches.size(), cameras.size());
    return std::nullopt;
  }
  mapping::AbsolutePose pose =
      PoseOfImage(*submap_from_vo, cameras, answer.matches, cameras.size() - 1, kDriftShare);
  BurstEvidence evidence = CountEvidence(answer.matches, pose);
  answer.median_distance_m = evidence.median_distance;
  InflateForRepetition(evidence, pose);
  pose.covariance =
      StatedCovariance(pose.covariance, cameras.back().camera, evidence.median_distance);
  if (auto refusal = FindReasonToRefuseBurst(cameras, answer.matches, pose, evidence,
                                             options.min_inliers, options.max_error_px)) {
    answer.refusal = *std::move(refusal);
  } else if (auto lens = FindLensContradiction(pose.inliers.size(), pose.focal_factor,
                                               options.focal_sigma_share)) {
    answer.refusal = *std::move(lens);
  } else if (auto scale =
                 FindScaleContradiction(evidence.landmarks(), submap_from_vo->odometry_scale)) {
    answer.refusal = *std::move(scale);
  } else {
    answer.submap_from_camera = std::move(pose);
    return evidence;
  }
  return std::nullopt;
}

}  // namespace

std::vector<BurstCamera> CamerasIn(const OpenSubmap& submap, const AskedBurst& burst) {
  const double submap_units_per_metre = 1 / submap.released().map_from_submap.sim().scale();
  const Eigen::Vector3d origin = burst.images.back().vo_from_camera.translation();
  std::vector<BurstCamera> cameras;
  for (const BurstImage& image : burst.images) {
    cameras.push_back({SensesIn(submap, image.request).camera,
                       {image.vo_from_camera.rotation(),
                        submap_units_per_metre * (image.vo_from_camera.translation() - origin)}});
  }
  return cameras;
}

BurstPoseOptions BurstPoseOptionsIn(const OpenSubmap& submap, const LocaliserOptions& options) {
  const Eigen::Quaterniond& map_from_submap = submap.released().map_from_submap.sim().rotation();
  return {.max_error_px = options.max_error_px,
          .min_inliers = options.min_inliers,
          .focal_sigma_share = options.focal_sigma_share,
          .up_in_submap = map_from_submap.conjugate() * Eigen::Vector3d::UnitZ(),
          .seed = options.seed};
}

std::vector<Candidate> AskBurst(std::span<const OpenSubmap> near, const AskedBurst& burst,
                                const CoarseQuantiser& quantiser, const LocaliserOptions& options,
                                StageTimes& times) {
  const Stopwatch ranking;
  std::vector<RankedCells> cells;
  for (const mapping::ImageFeatures& features : burst.features) {
    cells.push_back(quantiser.Rank(features.descriptors, options.probes));
  }
  times.search_ms += 1e3 * ranking.ElapsedS();
  std::vector<Candidate> candidates;
  for (const OpenSubmap& submap : near) {
    SubmapAnswer answer = FindMatches(submap, burst, cells);
    times.search_ms += answer.search_ms;
    const Stopwatch watch;
    const auto evidence = EstimatePose(submap, burst, options, answer);
    Candidate candidate = CarryToMap(submap, std::move(answer), burst.last(), options);
    if (candidate.pose) {
      candidate.pose->inliers = static_cast<int>(evidence->landmarks());
      candidate.pose->images = static_cast<int>(evidence->images);
    }
    candidates.push_back(std::move(candidate));
    times.pose_ms += 1e3 * watch.ElapsedS();
  }
  std::stable_sort(candidates.begin(), candidates.end(), IsMoreConvincing);
  return candidates;
}

}  // namespace waymark::localiser::internal
