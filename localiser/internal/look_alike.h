// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "localiser/internal/image_matches.h"
#include "mapping/base/result.h"
#include "mapping/estimation/absolute_pose.h"

namespace waymark::localiser::internal {

/// Another pose that the same image has in the same submap.
struct LookAlike {
  std::size_t agreeing = 0;  ///< matches that agree on it, none of them on the first pose,
  std::size_t matches = 0;   ///< of so many that do not agree on the first
  double distance_m = 0;     ///< between the two poses
};

/// The matches that are not among the inliers, which are ascending.
ImageMatches WithoutInliers(const ImageMatches& matches, std::span<const std::uint32_t> inliers);

/// Whether a second pose is elsewhere, and so many matches that agree on it show another place and
/// do not just happen to. Few do where a front repeats its windows: whoever took one row of them
/// for another would find more matches on the true row than on the false one. Units: the distance
/// is that to what the first pose sees.
bool IsLookAlike(const Rigid3& second, std::size_t agreeing, const Rigid3& first,
                 std::size_t first_agreeing, double median_distance);

/// Options under which a second pose is sought.
inline constexpr int kMinLookAlikeInliers = 5;
inline constexpr int kMaxLookAlikeDraws = 3000;

/// Looks for a second pose among the matches that do not agree on the first one. Houses that are
/// built alike share the matches of an image between them, wherever each was mapped from a more
/// similar place than the others; what a place of its own leaves over agrees on nothing.
/// nullopt: no pose elsewhere has enough matches.
/// Deterministic. Errors: those of EstimateAbsolutePose.
Result<std::optional<LookAlike>> FindLookAlike(const ImageSenses& senses,
                                               const ImageMatches& matches,
                                               const mapping::AbsolutePose& pose,
                                               double median_distance_m, double max_error_px);

}  // namespace waymark::localiser::internal
