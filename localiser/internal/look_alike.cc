// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/look_alike.h"

#include <vector>

namespace waymark::localiser::internal {
namespace {

// Of 1,393 poses in a city where no house is like another, second poses had at most 10 matches;
// none had more than a quarter of the first one's, and none of those with 8 or more a twentieth.
constexpr int kMinAgreeing = 5;
constexpr double kComparableShare = 0.25;  // of the first pose's inliers: always another place
constexpr std::size_t kManyAgreeing = 8;   // another place already for a
constexpr double kNotableShare = 0.05;     // of the first pose's inliers
constexpr double kSamePlace = 0.1;         // of the distance to what is seen
constexpr Angle kSameDirection = Angle::Degrees(5);
constexpr int kMaxIterations = 3000;

bool IsNotable(std::size_t agreeing, std::size_t first_agreeing) {
  const double share = static_cast<double>(agreeing) / static_cast<double>(first_agreeing);
  return share >= kComparableShare || (agreeing >= kManyAgreeing && share >= kNotableShare);
}

}  // namespace

Result<std::optional<LookAlike>> FindLookAlike(const ImageSenses& senses,
                                               const ImageMatches& matches,
                                               const mapping::AbsolutePose& pose,
                                               double median_distance_m, double max_error_px) {
  std::vector<Eigen::Vector2d> rest_px;
  std::vector<Eigen::Vector3d> rest_in_submap;
  auto inlier = pose.inliers.begin();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (inlier != pose.inliers.end() && *inlier == i) {
      ++inlier;
      continue;
    }
    rest_px.push_back(matches.pixels_px[i]);
    rest_in_submap.push_back(matches.points_in_submap[i]);
  }
  WAYMARK_TRY_ASSIGN(const auto second,
                     mapping::EstimateAbsolutePose(senses.camera, rest_px, rest_in_submap, {},
                                                   {.max_error_px = max_error_px,
                                                    .min_inliers = kMinAgreeing,
                                                    .max_iterations = kMaxIterations,
                                                    .up = senses.up}));
  std::optional<LookAlike> found;
  if (!second || !IsNotable(second->inliers.size(), pose.inliers.size())) return found;
  const double distance_m =
      (second->world_from_camera.translation() - pose.world_from_camera.translation()).norm();
  const Angle turn =
      AngleBetween(second->world_from_camera.rotation(), pose.world_from_camera.rotation());
  if (distance_m <= kSamePlace * median_distance_m && turn <= kSameDirection) return found;
  found = LookAlike{second->inliers.size(), rest_px.size(), distance_m};
  return found;
}

}  // namespace waymark::localiser::internal
