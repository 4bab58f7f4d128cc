// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "mapping/store/release.h"
#include "session/state/messages.h"

namespace waymark::session {

/// The submaps that shall carry an anchor to later releases, at most 3, best first: those it was
/// seen in, then those whose cameras were nearest. Law: for every attachment,
/// CarryPose(map_from_submap, submap_from_anchor) is map_from_anchor.
std::vector<content::SubmapAttachment> AttachToSubmaps(
    const Transform<Map, Anchor>& map_from_anchor, std::span<const SubmapId> seen_in,
    const mapping::Release& release);

/// Where all submaps of a release lie.
Placements PlacementsOf(const mapping::Release& release);

}  // namespace waymark::session
