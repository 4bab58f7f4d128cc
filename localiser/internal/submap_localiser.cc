// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/submap_localiser.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "localiser/internal/look_alike.h"
#include "localiser/internal/pose_acceptance.h"
#include "localiser/internal/stated_covariance.h"
#include "mapping/base/stopwatch.h"
#include "mapping/matching/representatives.h"

namespace waymark::localiser::internal {
namespace {

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

// Drives past the same front see a landmark many times nearly alike: two of its descriptors stand
// for all, and what is not there need not be read for every image.
constexpr mapping::RepresentativeOptions kRepresentatives{.max_count = 2};

struct Entries {
  std::vector<mapping::Descriptor> descriptors;
  std::vector<std::uint32_t> landmarks;
};

/// Shapes: the sightings of one landmark lie together.
Entries ChooseEntries(std::span<const mapping::Descriptor> descriptors,
                      std::span<const std::uint32_t> observed_landmarks) {
  Entries entries;
  for (std::size_t begin = 0, end = 0; begin < descriptors.size(); begin = end) {
    while (end < descriptors.size() && observed_landmarks[end] == observed_landmarks[begin]) ++end;
    const auto sightings = descriptors.subspan(begin, end - begin);
    for (const std::uint32_t index : ChooseRepresentatives(sightings, kRepresentatives)) {
      entries.descriptors.push_back(sightings[index]);
      entries.landmarks.push_back(observed_landmarks[begin]);
    }
  }
  return entries;
}

std::variant<LandmarkSearch, KdTreeSearch> MakeSearch(
    std::span<const mapping::Descriptor> descriptors,
    std::span<const std::uint32_t> observed_landmarks, const CoarseQuantiser& quantiser,
    const LocaliserOptions& options) {
  const Entries entries = ChooseEntries(descriptors, observed_landmarks);
  const LandmarkSearchOptions search{.max_ratio = options.max_ratio};
  if (options.search == SearchMethod::kKdTrees) {
    return KdTreeSearch(entries.descriptors, entries.landmarks, search);
  }
  return LandmarkSearch(entries.descriptors, entries.landmarks, quantiser, search);
}

template <typename... Kinds>
struct Overloaded : Kinds... {
  using Kinds::operator()...;
};

}  // namespace

SubmapLocaliser::SubmapLocaliser(std::span<const Eigen::Vector3d> landmarks_in_submap,
                                 std::span<const mapping::Descriptor> descriptors,
                                 std::span<const std::uint32_t> observed_landmarks,
                                 const CoarseQuantiser& quantiser, const LocaliserOptions& options)
    : options_(options),
      landmarks_in_submap_(landmarks_in_submap),
      search_(MakeSearch(descriptors, observed_landmarks, quantiser, options)) {}

std::size_t SubmapLocaliser::bytes() const {
  return std::visit([](const auto& search) { return search.bytes(); }, search_);
}

ImageMatches SubmapLocaliser::Match(const mapping::ImageFeatures& features,
                                    std::vector<LandmarkMatch> found) const {
  ImageMatches matches;
  for (const LandmarkMatch& match : KeepOnePerLandmarkAndPlace(features, std::move(found))) {
    const mapping::Keypoint& keypoint = features.keypoints[match.feature];
    matches.pixels_px.emplace_back(keypoint.x_px, keypoint.y_px);
    matches.points_in_submap.push_back(landmarks_in_submap_[match.landmark]);
    matches.quality.push_back(1 - match.ratio);
    matches.landmarks.push_back(match.landmark);
  }
  return matches;
}

SubmapAnswer SubmapLocaliser::FindMatches(const mapping::ImageFeatures& features,
                                          const RankedCells& cells) const {
  SubmapAnswer answer;
  const Stopwatch search_watch;
  FoundLandmarks found = std::visit(
      Overloaded{
          [&](const LandmarkSearch& lists) { return lists.Match(features.descriptors, cells); },
          [&](const KdTreeSearch& trees) { return trees.Match(features.descriptors); }},
      search_);
  answer.matches = Match(features, std::move(found.matches));
  answer.resemblances = std::move(found.resemblances);
  answer.search_ms = 1e3 * search_watch.ElapsedS();
  return answer;
}

SubmapAnswer SubmapLocaliser::Localise(const mapping::ImageFeatures& features,
                                       const RankedCells& cells, const ImageSenses& senses) const {
  SubmapAnswer answer = FindMatches(features, cells);
  EstimatePose(senses, answer);
  return answer;
}

void SubmapLocaliser::EstimatePose(const ImageSenses& senses, SubmapAnswer& answer) const {
  const ImageMatches& matches = answer.matches;
  answer.submap_from_camera.reset();
  if (matches.size() < static_cast<std::size_t>(options_.min_inliers)) {
    answer.refusal =
        fmt::format("{} matches, at least {} are needed", matches.size(), options_.min_inliers);
    return;
  }
  const Stopwatch watch;
  auto estimated = mapping::EstimateAbsolutePose(senses.camera, matches.pixels_px,
                                                 matches.points_in_submap, matches.quality,
                                                 {.max_error_px = options_.max_error_px,
                                                  .min_inliers = options_.min_inliers,
                                                  .focal_sigma_share = options_.focal_sigma_share,
                                                  .up = senses.up,
                                                  .seed = options_.seed});
  if (!estimated) {
    answer.refusal = ToString(estimated.error());
  } else if (!*estimated) {
    answer.refusal =
        fmt::format("no pose agrees with {} of {} matches", options_.min_inliers, matches.size());
  } else {
    mapping::AbsolutePose& pose = **estimated;
    answer.median_distance_m =
        matches.MedianDistance(pose.inliers, pose.world_from_camera.translation());
    pose.covariance = StatedCovariance(pose.covariance, senses.camera, answer.median_distance_m);
    if (auto refusal = Judge(senses.camera, pose, answer)) {
      answer.refusal = *std::move(refusal);
    } else {
      answer.submap_from_camera = std::move(pose);
    }
  }
  answer.pose_ms += 1e3 * watch.ElapsedS();
}

std::optional<std::string> SubmapLocaliser::Judge(const CameraModel& camera,
                                                  const mapping::AbsolutePose& pose,
                                                  const SubmapAnswer& answer) const {
  const ImageMatches& matches = answer.matches;
  std::vector<Eigen::Vector2d> inliers_px;
  for (const std::uint32_t inlier : pose.inliers) {
    inliers_px.push_back(matches.pixels_px[inlier]);
  }
  if (auto refusal =
          FindReasonToRefuse({.matches = matches.size(),
                              .inliers_px = inliers_px,
                              .position_covariance = pose.covariance.topLeftCorner<3, 3>(),
                              .median_distance_m = answer.median_distance_m,
                              .max_error_px = options_.max_error_px},
                             camera)) {
    return refusal;
  }
  return FindLensContradiction(pose.inliers.size(), pose.focal_factor, options_.focal_sigma_share);
}

std::string SubmapLocaliser::FindAmbiguity(const ImageSenses& senses,
                                           const SubmapAnswer& answer) const {
  const mapping::AbsolutePose& pose = *answer.submap_from_camera;
  const auto twin =
      FindLookAlike(senses, answer.matches, pose, answer.median_distance_m, options_.max_error_px);
  if (!twin || !*twin) return {};
  return fmt::format(
      "two places look alike: {} matches agree on a pose, {} of the other {} on one {:.1f} m away",
      pose.inliers.size(), (*twin)->agreeing, (*twin)->matches, (*twin)->distance_m);
}

}  // namespace waymark::localiser::internal
