// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "localiser/internal/image_matches.h"
#include "mapping/estimation/absolute_pose.h"

namespace waymark::localiser::internal {

/// What a burst's pose rests on. Pictures of one thing are no independent witnesses: whoever is
/// mistaken about it once will be again, so landmarks are counted, not matches.
struct BurstEvidence {
  std::vector<std::uint32_t> inliers;  ///< the first of each landmark
  std::size_t landmarks() const { return inliers.size(); }
  std::size_t images = 0;      ///< that show inliers
  double median_distance = 0;  ///< from the last image to those landmarks, in the submap's units
};

/// Shapes: `pose` is that of the last camera, its inliers are indices of matches, at least one.
BurstEvidence CountEvidence(const ImageMatches& matches, const mapping::AbsolutePose& pose);

/// Why the pose is not to be trusted, with figures, by the limits for one image: how many landmarks
/// agree, in how many parts of what the last camera would see with eyes all around, and how well
/// they fix it.
std::optional<std::string> FindReasonToRefuseBurst(std::span<const BurstCamera> cameras,
                                                   const ImageMatches& matches,
                                                   const mapping::AbsolutePose& pose,
                                                   const BurstEvidence& evidence, int min_landmarks,
                                                   double max_error_px);

/// Whether the metre that a burst's inliers fit with is nearly odometry's: few landmarks bend to an
/// odometry that is wrong. nullopt: it is.
std::optional<std::string> FindScaleContradiction(std::size_t landmarks, double odometry_scale);

}  // namespace waymark::localiser::internal
