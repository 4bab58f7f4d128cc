// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/ambiguity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "mapping/base/median.h"
#include "mapping/matching/descriptor_matching.h"

namespace waymark::localiser::internal {
namespace {

// Submaps that overlap see the same image within decimetres; copies of a place are far apart.
constexpr double kSamePlaceM = 5;
constexpr Angle kSameDirection = Angle::Degrees(15);
constexpr double kComparableShare = 0.6;  // of the inliers

constexpr double kNearlyAsMuch = 1.3;  // times the angle to what a feature looks like most
constexpr double kMinRivalM = 1.5;     // nearer is the same place
constexpr double kRivalShare = 0.15;   // of the distance to what is seen: the same place too
// Of 1,056 poses in a street without copies that six drives mapped three had as much; of 20 false
// poses among copied houses that the other ways missed all but one.
constexpr double kMaxRivals = 0.09;  // Rivalry::Share
constexpr double kClearRatio = 0.5;  // clearer matches than these speak for themselves

double DistanceM(const Rigid3& a, const Rigid3& b) {
  return (a.translation() - b.translation()).norm();
}

/// The least dot product that is nearly as much as each feature's best, in all submaps.
std::vector<std::int32_t> LeastDots(std::span<const Candidate> candidates, std::size_t features) {
  std::vector<std::int32_t> dots(features, 0);
  for (const Candidate& candidate : candidates) {
    for (const Resemblance& found : candidate.answer.resemblances) {
      dots[found.feature] = std::max(dots[found.feature], found.dot);
    }
  }
  for (std::int32_t& dot : dots) {
    const double angle_rad = kNearlyAsMuch * mapping::DescriptorAngle(dot);
    dot = static_cast<std::int32_t>(mapping::kSquaredDescriptorLength * std::cos(angle_rad));
  }
  return dots;
}

/// Where each image's features begin, and one end.
std::vector<std::uint32_t> FeatureBegins(std::span<const AskedImage> images) {
  std::vector<std::uint32_t> begins{0};
  for (const AskedImage& image : images) {
    begins.push_back(begins.back() + static_cast<std::uint32_t>(image.features->keypoints.size()));
  }
  return begins;
}

std::vector<SeenResemblance> GatherResemblances(std::span<const Candidate> candidates,
                                                std::span<const AskedImage> images) {
  const std::vector<std::uint32_t> begins = FeatureBegins(images);
  const std::vector<std::int32_t> least_dots = LeastDots(candidates, begins.back());
  std::vector<SeenResemblance> seen;
  for (const Candidate& candidate : candidates) {
    const Sim3& map_from_submap = candidate.submap->released().map_from_submap.sim();
    const auto landmarks = candidate.submap->view().landmarks_in_submap();
    for (const Resemblance& found : candidate.answer.resemblances) {
      if (found.dot < least_dots[found.feature]) continue;
      const auto end = std::upper_bound(begins.begin(), begins.end(), found.feature);
      const auto image = static_cast<std::uint32_t>(end - begins.begin() - 1);
      const mapping::Keypoint& keypoint =
          images[image].features->keypoints[found.feature - begins[image]];
      seen.push_back({found.feature,
                      image,
                      {keypoint.x_px, keypoint.y_px},
                      map_from_submap * landmarks[found.landmark]});
    }
  }
  std::stable_sort(seen.begin(), seen.end(),
                   [](const auto& a, const auto& b) { return a.feature < b.feature; });
  return seen;
}

/// Of the angles to the landmarks of the inliers over those to the best others.
double MedianRatio(const SubmapAnswer& answer) {
  std::vector<double> ratios;
  for (const std::uint32_t inlier : answer.submap_from_camera->inliers) {
    ratios.push_back(1 - answer.matches.quality[inlier]);
  }
  return Median(std::move(ratios));
}

}  // namespace

std::optional<std::string> FindOtherCandidate(std::span<const Candidate> candidates) {
  const LocalisedPose& best = *candidates.front().pose;
  for (const Candidate& other : candidates.subspan(1)) {
    if (!other.pose || other.pose->inliers < kComparableShare * best.inliers) break;
    const double distance_m =
        DistanceM(other.pose->map_from_camera.rigid(), best.map_from_camera.rigid());
    const Angle turn =
        AngleBetween(other.pose->map_from_camera.rotation(), best.map_from_camera.rotation());
    if (distance_m <= kSamePlaceM && turn <= kSameDirection) continue;
    return fmt::format("two places look alike: {} inliers in submap {}, {} in {}, {:.1f} m apart",
                       best.inliers, best.submap.text(), other.pose->inliers,
                       other.pose->submap.text(), distance_m);
  }
  return std::nullopt;
}

std::optional<std::string> FindRivalOf(std::span<const Candidate> candidates,
                                       std::span<const AskedImage> images,
                                       const LocaliserOptions& options) {
  const Candidate& best = candidates.front();
  if (MedianRatio(best.answer) < kClearRatio) return std::nullopt;
  std::vector<PlacedImage> placed;
  for (const AskedImage& image : images) placed.push_back(image.placed);
  const double scale = best.submap->released().map_from_submap.sim().scale();
  const Rivalry rivalry = FindRival(
      placed, GatherResemblances(candidates, images),
      {.max_error_px = options.max_error_px,
       .same_place_m = std::max(kMinRivalM, kRivalShare * scale * best.answer.median_distance_m)});
  if (rivalry.Share() < kMaxRivals) return std::nullopt;
  return fmt::format(
      "two places look alike: {} features fit a pose, {:.0f} by chance; {} fit one {:.1f} m away, "
      "{:.0f} by chance",
      rivalry.supporters, rivalry.chance_supporters, rivalry.rivals,
      DistanceM(rivalry.map_from_camera, best.pose->map_from_camera.rigid()),
      rivalry.chance_rivals);
}

std::optional<std::string> FindAmbiguity(std::span<const Candidate> candidates,
                                         const mapping::ImageFeatures& features,
                                         const LocalisationRequest& request,
                                         const LocaliserOptions& options) {
  if (auto other = FindOtherCandidate(candidates)) return other;
  const Candidate& best = candidates.front();
  std::string twin =
      best.submap->localiser().FindAmbiguity(SensesIn(*best.submap, request), best.answer);
  if (!twin.empty()) return twin;
  const double focal_factor = best.answer.submap_from_camera->focal_factor;
  const AskedImage asked{&features,
                         {SensesIn(*best.submap, request).camera.WithScaledFocal(focal_factor),
                          best.pose->map_from_camera.rigid()}};
  return FindRivalOf(candidates, {&asked, 1}, options);
}

}  // namespace waymark::localiser::internal
