// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/burst/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "localiser/internal/ambiguity.h"
#include "localiser/internal/burst/evidence.h"
#include "localiser/internal/look_alike.h"

namespace waymark::localiser::internal {
namespace {

constexpr double kKeptShare = 0.6;            // of an image's own inliers
constexpr std::ptrdiff_t kMinOwnInliers = 3;  // chance gives one to an image in a hundred

ImageMatches OfImage(const ImageMatches& all, std::uint32_t image) {
  ImageMatches matches;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all.images[i] == image) matches.Add(all, i, std::nullopt);
  }
  return matches;
}

/// Where the pose of the last image puts each.
std::vector<AskedImage> PlaceImages(const Candidate& candidate, const AskedBurst& burst) {
  const double focal_factor = candidate.answer.submap_from_camera->focal_factor;
  const Rigid3 map_from_vo = candidate.pose->map_from_camera.rigid() *
                             burst.images.back().vo_from_camera.rigid().Inverse();
  std::vector<AskedImage> placed;
  for (std::size_t i = 0; i < burst.images.size(); ++i) {
    const BurstImage& image = burst.images[i];
    const CameraModel camera = SensesIn(*candidate.submap, image.request).camera;
    placed.push_back(
        {&burst.features[i],
         {camera.WithScaledFocal(focal_factor), map_from_vo * image.vo_from_camera.rigid()}});
  }
  return placed;
}

std::optional<std::string> FindTwinPose(const Candidate& candidate, const AskedBurst& burst,
                                        const LocaliserOptions& options) {
  const SubmapAnswer& answer = candidate.answer;
  const mapping::AbsolutePose& first = *answer.submap_from_camera;
  const std::vector<BurstCamera> cameras = CamerasIn(*candidate.submap, burst);
  BurstPoseOptions pose_options = BurstPoseOptionsIn(*candidate.submap, options);
  pose_options.min_inliers = kMinLookAlikeInliers;
  pose_options.max_draws = kMaxLookAlikeDraws;
  pose_options.focal_sigma_share = 0;
  const ImageMatches rest = WithoutInliers(answer.matches, first.inliers);
  const auto second_vo = EstimateBurstPose(cameras, rest, pose_options);
  if (!second_vo) return std::nullopt;
  const auto second = PoseOfImage(*second_vo, cameras, rest, cameras.size() - 1, 0);
  const std::size_t agreeing = CountEvidence(rest, second).landmarks();
  const std::size_t first_agreeing = CountEvidence(answer.matches, first).landmarks();
  if (!IsLookAlike(second.world_from_camera, agreeing, first.world_from_camera, first_agreeing,
                   answer.median_distance_m)) {
    return std::nullopt;
  }
  return fmt::format(
      "two places look alike: {} landmarks agree on a pose, {} others on one {:.1f} m away",
      first_agreeing, agreeing,
      (second.world_from_camera.translation() - first.world_from_camera.translation()).norm());
}

}  // namespace

std::optional<std::string> FindOdometryContradiction(const Candidate& candidate,
                                                     const AskedBurst& burst) {
  const OpenSubmap& submap = *candidate.submap;
  const ImageMatches& matches = candidate.answer.matches;
  for (std::uint32_t i = 0; i < burst.images.size(); ++i) {
    SubmapAnswer own;
    own.matches = OfImage(matches, i);
    submap.localiser().EstimatePose(SensesIn(submap, burst.images[i].request), own);
    if (!own.submap_from_camera) continue;
    const std::size_t alone = own.submap_from_camera->inliers.size();
    const auto kept =
        std::ranges::count_if(candidate.answer.submap_from_camera->inliers,
                              [&](std::uint32_t inlier) { return matches.images[inlier] == i; });
    if (static_cast<double>(kept) >= kKeptShare * static_cast<double>(alone)) continue;
    return fmt::format("odometry contradicts image {} of {}: {} inliers alone, {} with the others",
                       i + 1, burst.images.size(), alone, kept);
  }
  return std::nullopt;
}

std::optional<std::string> FindAbsence(const Candidate& candidate, const AskedBurst& burst) {
  if (burst.fallback != BurstFallback::kNone) return std::nullopt;
  const auto& images = candidate.answer.matches.images;
  const auto own = std::ranges::count_if(
      candidate.answer.submap_from_camera->inliers,
      [&](std::uint32_t inlier) { return images[inlier] + 1 == burst.images.size(); });
  if (own >= kMinOwnInliers) return std::nullopt;
  return fmt::format("odometry alone speaks for the last image, which shows {} of {} inliers", own,
                     candidate.answer.submap_from_camera->inliers.size());
}

std::optional<std::string> FindBurstAmbiguity(std::span<const Candidate> candidates,
                                              const AskedBurst& burst,
                                              const LocaliserOptions& options) {
  if (auto other = FindOtherCandidate(candidates)) return other;
  if (auto twin = FindTwinPose(candidates.front(), burst, options)) return twin;
  return FindRivalOf(candidates, PlaceImages(candidates.front(), burst), options);
}

std::optional<std::string> FindContradiction(const Candidate& candidate, const AskedBurst& burst,
                                             const LocaliserOptions& options) {
  const std::vector<AskedImage> placed = PlaceImages(candidate, burst);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (auto contradiction =
            FindContradiction(Transform<Map, Camera>(placed[i].placed.map_from_camera),
                              candidate.pose->inliers, burst.images[i].request, options)) {
      return fmt::format("image {} of {}: {}", i + 1, placed.size(), *contradiction);
    }
  }
  return std::nullopt;
}

}  // namespace waymark::localiser::internal
