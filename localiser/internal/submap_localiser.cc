// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/submap_localiser.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "localiser/internal/look_alike.h"
#include "localiser/internal/pose_acceptance.h"
#include "localiser/internal/stated_covariance.h"
#include "mapping/base/median.h"
#include "mapping/base/stopwatch.h"

namespace waymark::localiser::internal {
namespace {

constexpr double kMaxFocalSigmas = 2.5;  // beyond its doubt, the lens is not the one stated

// A landmark is seen once in an image, and one place in it shows one landmark: features of several
// orientations share their place and must not be counted as independent evidence.
std::vector<LandmarkMatch> KeepOnePerLandmarkAndPlace(const mapping::ImageFeatures& features,
                                                      std::vector<LandmarkMatch> matches) {
  std::sort(matches.begin(), matches.end(), [](const LandmarkMatch& a, const LandmarkMatch& b) {
    return std::tie(a.ratio, a.feature) < std::tie(b.ratio, b.feature);
  });
  std::set<std::uint32_t> landmarks;
  std::set<std::pair<float, float>> places;
  std::erase_if(matches, [&](const LandmarkMatch& match) {
    const mapping::Keypoint& keypoint = features.keypoints[match.feature];
    return !landmarks.insert(match.landmark).second ||
           !places.insert({keypoint.x_px, keypoint.y_px}).second;
  });
  return matches;
}

}  // namespace

SubmapLocaliser::SubmapLocaliser(std::span<const Eigen::Vector3d> landmarks_in_submap,
                                 std::span<const mapping::Descriptor> descriptors,
                                 std::span<const std::uint32_t> observed_landmarks,
                                 const CoarseQuantiser& quantiser, const LocaliserOptions& options)
    : options_(options),
      landmarks_in_submap_(landmarks_in_submap),
      search_(descriptors, observed_landmarks, quantiser,
              LandmarkSearchOptions{.max_ratio = options.max_ratio}) {}

SubmapAnswer SubmapLocaliser::Localise(const mapping::ImageFeatures& features,
                                       const RankedCells& cells, const CameraModel& camera) const {
  const Stopwatch search_watch;
  const std::vector<LandmarkMatch> matches =
      KeepOnePerLandmarkAndPlace(features, search_.Match(features.descriptors, cells));
  const double search_ms = 1e3 * search_watch.ElapsedS();
  const Stopwatch pose_watch;
  SubmapAnswer answer = EstimatePose(features, camera, matches);
  answer.matches = matches.size();
  answer.search_ms = search_ms;
  answer.pose_ms = 1e3 * pose_watch.ElapsedS();
  return answer;
}

SubmapAnswer SubmapLocaliser::EstimatePose(const mapping::ImageFeatures& features,
                                           const CameraModel& camera,
                                           std::span<const LandmarkMatch> matches) const {
  SubmapAnswer answer;
  if (matches.size() < static_cast<std::size_t>(options_.min_inliers)) {
    answer.refusal =
        fmt::format("{} matches, at least {} are needed", matches.size(), options_.min_inliers);
    return answer;
  }
  std::vector<Eigen::Vector2d> pixels_px;
  std::vector<Eigen::Vector3d> points_in_submap;
  std::vector<double> quality;
  for (const LandmarkMatch& match : matches) {
    const mapping::Keypoint& keypoint = features.keypoints[match.feature];
    pixels_px.emplace_back(keypoint.x_px, keypoint.y_px);
    points_in_submap.push_back(landmarks_in_submap_[match.landmark]);
    quality.push_back(1 - match.ratio);
  }
  auto estimated = mapping::EstimateAbsolutePose(camera, pixels_px, points_in_submap, quality,
                                                 {.max_error_px = options_.max_error_px,
                                                  .min_inliers = options_.min_inliers,
                                                  .focal_sigma_share = options_.focal_sigma_share,
                                                  .seed = options_.seed});
  if (!estimated) {
    answer.refusal = ToString(estimated.error());
    return answer;
  }
  if (!*estimated) {
    answer.refusal =
        fmt::format("no pose agrees with {} of {} matches", options_.min_inliers, matches.size());
    return answer;
  }
  mapping::AbsolutePose& pose = **estimated;
  pose.covariance = StatedCovariance(pose.covariance, camera);
  std::vector<Eigen::Vector2d> inliers_px;
  std::vector<double> distances_m;
  for (const std::uint32_t inlier : pose.inliers) {
    inliers_px.push_back(pixels_px[inlier]);
    distances_m.push_back((points_in_submap[inlier] - pose.world_from_camera.translation()).norm());
  }
  const double median_distance_m = Median(distances_m);
  const auto refusal =
      FindReasonToRefuse({.matches = matches.size(),
                          .inliers_px = inliers_px,
                          .position_covariance = pose.covariance.topLeftCorner<3, 3>(),
                          .median_distance_m = median_distance_m,
                          .max_error_px = options_.max_error_px},
                         camera);
  if (refusal) {
    answer.refusal = *refusal;
    return answer;
  }
  if (std::abs(pose.focal_factor - 1) > kMaxFocalSigmas * options_.focal_sigma_share) {
    answer.refusal =
        fmt::format("{} inliers contradict the stated focal length: they fit with {:.2f} times it",
                    pose.inliers.size(), pose.focal_factor);
    return answer;
  }
  const auto twin = FindLookAlike(camera, pixels_px, points_in_submap, pose, median_distance_m,
                                  options_.max_error_px);
  if (twin && *twin) {
    answer.ambiguity = fmt::format(
        "two places look alike: {} matches agree on a pose, {} of the other {} on one {:.1f} m "
        "away",
        pose.inliers.size(), (*twin)->agreeing, (*twin)->matches, (*twin)->distance_m);
  }
  answer.submap_from_camera = std::move(pose);
  return answer;
}

}  // namespace waymark::localiser::internal
