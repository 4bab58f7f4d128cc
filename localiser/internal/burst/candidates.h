// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "localiser/internal/burst/pose.h"
#include "localiser/internal/candidate.h"
#include "localiser/internal/coarse_quantiser.h"
#include "localiser/localiser.h"
#include "mapping/features/features.h"

namespace waymark::localiser::internal {

/// A burst on its way through the submaps. Every request states gravity.
struct AskedBurst {
  std::span<const BurstImage> images;
  std::span<const mapping::ImageFeatures> features;
  BurstFallback fallback = BurstFallback::kLastAlone;

  const LocalisationRequest& last() const { return images.back().request; }
};

/// What each submap makes of all images together, the most convincing first. In the answers,
/// features are numbered on from image to image, matches name their image, and the pose is that of
/// the last image; inliers of poses in the map are landmarks.
/// Adds to search_ms and pose_ms.
std::vector<Candidate> AskBurst(std::span<const OpenSubmap> near, const AskedBurst& burst,
                                const CoarseQuantiser& quantiser, const LocaliserOptions& options,
                                StageTimes& times);

/// The burst's cameras in the submap's units; odometry's frame is moved to the last one, where the
/// answer is sought.
std::vector<BurstCamera> CamerasIn(const OpenSubmap& submap, const AskedBurst& burst);

BurstPoseOptions BurstPoseOptionsIn(const OpenSubmap& submap, const LocaliserOptions& options);

}  // namespace waymark::localiser::internal
