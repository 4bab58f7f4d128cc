// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <utility>
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

/// A release with its submaps by name. Immutable.
struct LiveRelease {
  explicit LiveRelease(mapping::Release of)
      : release(std::move(of)), placements(PlacementsOf(release)) {}

  mapping::Release release;
  Placements placements;
};

/// How many of its attachments are to submaps of a release.
std::size_t CountLive(const content::AnchorRecord& record, const LiveRelease& live);

/// The anchor in the map of a release, with three attachments to its submaps as far as there are so
/// many near it; as it was if none of its submaps is there. Those left keep their attachment to the
/// bit and their order, so the anchor does not move. A new one goes before them if it is nearer.
/// Submaps that are gone keep what places are free, in case they come back.
content::AnchorRecord HoldIn(const LiveRelease& live, const content::AnchorRecord& record);

}  // namespace waymark::session
