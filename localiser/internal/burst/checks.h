// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "localiser/internal/burst/candidates.h"

namespace waymark::localiser::internal {

/// How odometry contradicts what images show by themselves: an image whose own pose in the submap
/// stands must keep most of its inliers in the pose of all. nullopt: it does not.
std::optional<std::string> FindOdometryContradiction(const Candidate& candidate,
                                                     const AskedBurst& burst);

/// Why the pose is carried to the last image by odometry alone, where there is no fallback: the
/// image shows too few of the inliers. nullopt: it shows enough, or need not.
std::optional<std::string> FindAbsence(const Candidate& candidate, const AskedBurst& burst);

/// As FindAmbiguity, for all images together.
std::optional<std::string> FindBurstAmbiguity(std::span<const Candidate> candidates,
                                              const AskedBurst& burst,
                                              const LocaliserOptions& options);

/// How what the phone knew of itself at some image contradicts the first candidate's pose.
std::optional<std::string> FindContradiction(const Candidate& candidate, const AskedBurst& burst,
                                             const LocaliserOptions& options);

}  // namespace waymark::localiser::internal
