// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/burst/evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "localiser/internal/pose_acceptance.h"

namespace waymark::localiser::internal {
namespace {

// Odometry is good to some per cent, and so is a map that only GNSS scales.
constexpr double kMaxScaleError = 0.15;

/// The first inlier of each landmark.
std::vector<std::uint32_t> OnePerLandmark(const ImageMatches& matches,
                                          const mapping::AbsolutePose& pose) {
  std::set<std::uint32_t> landmarks;
  std::vector<std::uint32_t> first;
  for (const std::uint32_t inlier : pose.inliers) {
    if (landmarks.insert(matches.landmarks[inlier]).second) first.push_back(inlier);
  }
  return first;
}

/// Parts as large as those of the last camera's image, around it: a landmark lies in one of them,
/// from wherever it was seen.
std::size_t CountParts(const CameraModel& camera, const ImageMatches& matches,
                       const mapping::AbsolutePose& pose, std::span<const std::uint32_t> inliers) {
  const double wide_rad = 2 * std::atan(0.5 * camera.width_px() / camera.FocalX()) / kImageParts;
  const double high_rad = 2 * std::atan(0.5 * camera.height_px() / camera.FocalY()) / kImageParts;
  const Rigid3 camera_from_submap = pose.world_from_camera.Inverse();
  std::set<std::pair<int, int>> parts;
  for (const std::uint32_t inlier : inliers) {
    const Eigen::Vector3d x = camera_from_submap * matches.points_in_submap[inlier];
    const double azimuth_rad = std::atan2(x.x(), x.z());
    const double height_rad = std::atan2(x.y(), std::hypot(x.x(), x.z()));
    parts.emplace(static_cast<int>(std::floor(azimuth_rad / wide_rad)),
                  static_cast<int>(std::floor(height_rad / high_rad)));
  }
  return parts.size();
}

}  // namespace

BurstEvidence CountEvidence(const ImageMatches& matches, const mapping::AbsolutePose& pose) {
  BurstEvidence evidence{.inliers = OnePerLandmark(matches, pose)};
  std::set<std::uint32_t> images;
  for (const std::uint32_t inlier : pose.inliers) images.insert(matches.images[inlier]);
  evidence.images = images.size();
  evidence.median_distance =
      matches.MedianDistance(evidence.inliers, pose.world_from_camera.translation());
  return evidence;
}

std::optional<std::string> FindScaleContradiction(std::size_t landmarks, double odometry_scale) {
  if (std::abs(odometry_scale - 1) <= kMaxScaleError) return std::nullopt;
  return fmt::format("{} landmarks contradict odometry's metre: they fit with {:.2f} times it",
                     landmarks, odometry_scale);
}

std::optional<std::string> FindReasonToRefuseBurst(std::span<const BurstCamera> cameras,
                                                   const ImageMatches& matches,
                                                   const mapping::AbsolutePose& pose,
                                                   const BurstEvidence& evidence, int min_landmarks,
                                                   double max_error_px) {
  if (evidence.landmarks() < static_cast<std::size_t>(min_landmarks)) {
    return fmt::format("the inliers show {} landmarks, at least {} are needed",
                       evidence.landmarks(), min_landmarks);
  }
  const std::set<std::uint32_t> landmarks(matches.landmarks.begin(), matches.landmarks.end());
  double chance = 0;  // of each landmark, however often it was matched
  for (const std::uint32_t image : matches.images) {
    chance += ChanceOfInlier(max_error_px, cameras[image].camera);
  }
  return FindReasonToRefuse(
      CountedEvidence{.matches = landmarks.size(),
                      .inliers = evidence.landmarks(),
                      .chance = chance / static_cast<double>(landmarks.size()),
                      .parts = CountParts(cameras.back().camera, matches, pose, evidence.inliers),
                      .position_covariance = pose.covariance.topLeftCorner<3, 3>(),
                      .median_distance_m = evidence.median_distance});
}

}  // namespace waymark::localiser::internal
