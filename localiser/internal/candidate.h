// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "localiser/internal/submap_localiser.h"
#include "localiser/localiser.h"
#include "mapping/store/release.h"

namespace waymark::localiser::internal {

/// What one submap says, in the map frame and compared with what the phone knows of itself.
struct Candidate {
  const mapping::ReleasedSubmap* submap = nullptr;
  std::size_t matches = 0;
  std::optional<LocalisedPose> pose;  ///< absent: see refusal
  std::string refusal;
  std::string ambiguity;  ///< of the pose, within its submap; empty: none
};

/// Carries an answer by map_from_submap and refuses it if gravity or the prior contradicts it.
Candidate CarryToMap(const mapping::ReleasedSubmap& submap, SubmapAnswer answer,
                     const LocalisationRequest& request, const LocaliserOptions& options);

/// By inliers; a candidate without a pose by its matches, after all that have one.
bool IsMoreConvincing(const Candidate& a, const Candidate& b);

/// Two places that look alike: within the submap of the first candidate, or another candidate with
/// nearly as many inliers as the first, but elsewhere. Shapes: sorted by IsMoreConvincing; the
/// first has a pose.
std::optional<std::string> FindAmbiguity(std::span<const Candidate> candidates);

}  // namespace waymark::localiser::internal
