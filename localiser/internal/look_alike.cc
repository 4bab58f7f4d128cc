// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/look_alike.h"

namespace waymark::localiser::internal {
namespace {

// In a city where no house is like another second poses of 1,393 pictures had at most 10 matches,
// none a quarter of the first one's. With more landmarks found, of 1,000 right poses of all lights
// five had 8 to 20 elsewhere, a twentieth to a seventh; those with more than 0.07 were a row of
// windows away.
constexpr double kComparableShare = 0.25;  // of the first pose's inliers: always another place
constexpr std::size_t kManyAgreeing = 8;   // another place already for a
constexpr double kNotableShare = 0.08;     // of the first pose's inliers
constexpr double kSamePlace = 0.1;         // of the distance to what is seen
constexpr Angle kSameDirection = Angle::Degrees(5);
constexpr double kSameFront = 0.3;  // likewise: windows are repeated so near, houses are not
constexpr Angle kAlongFront = Angle::Degrees(15);

bool IsElsewhere(const Rigid3& second, const Rigid3& first, double median_distance) {
  return (second.translation() - first.translation()).norm() > kSamePlace * median_distance ||
         AngleBetween(second.rotation(), first.rotation()) > kSameDirection;
}

}  // namespace

ImageMatches WithoutInliers(const ImageMatches& matches, std::span<const std::uint32_t> inliers) {
  ImageMatches rest;
  auto inlier = inliers.begin();
  for (std::uint32_t i = 0; i < matches.size(); ++i) {
    if (inlier != inliers.end() && *inlier == i) {
      ++inlier;
      continue;
    }
    rest.Add(matches, i, matches.images.empty() ? std::nullopt : std::optional(matches.images[i]));
  }
  return rest;
}

bool IsLookAlike(const Rigid3& second, std::size_t agreeing, const Rigid3& first,
                 std::size_t first_agreeing, double median_distance) {
  if (!IsElsewhere(second, first, median_distance)) return false;
  const double share = static_cast<double>(agreeing) / static_cast<double>(first_agreeing);
  if (share >= kComparableShare) return true;
  const bool is_beside =
      (second.translation() - first.translation()).norm() <= kSameFront * median_distance &&
      AngleBetween(second.rotation(), first.rotation()) <= kAlongFront;
  return !is_beside && agreeing >= kManyAgreeing && share >= kNotableShare;
}

Result<std::optional<LookAlike>> FindLookAlike(const ImageSenses& senses,
                                               const ImageMatches& matches,
                                               const mapping::AbsolutePose& pose,
                                               double median_distance_m, double max_error_px) {
  const ImageMatches rest = WithoutInliers(matches, pose.inliers);
  WAYMARK_TRY_ASSIGN(
      const auto second,
      mapping::EstimateAbsolutePose(senses.camera, rest.pixels_px, rest.points_in_submap, {},
                                    {.max_error_px = max_error_px,
                                     .min_inliers = kMinLookAlikeInliers,
                                     .max_iterations = kMaxLookAlikeDraws,
                                     .up = senses.up}));
  std::optional<LookAlike> found;
  if (!second || !IsLookAlike(second->world_from_camera, second->inliers.size(),
                              pose.world_from_camera, pose.inliers.size(), median_distance_m)) {
    return found;
  }
  found = LookAlike{
      second->inliers.size(), rest.size(),
      (second->world_from_camera.translation() - pose.world_from_camera.translation()).norm()};
  return found;
}

}  // namespace waymark::localiser::internal
