// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "localiser/internal/candidate.h"
#include "mapping/base/id.h"

namespace waymark::localiser::internal {

/// The experience whose images show most of the landmarks that a candidate's pose agrees with; of
/// equals the one that the submap names first. A landmark counts once for everybody who saw it.
/// nullopt: the candidate has no pose, or its submap no images.
std::optional<ExperienceId> FindContributor(const Candidate& candidate);

}  // namespace waymark::localiser::internal
