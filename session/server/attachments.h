// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "mapping/geometry/geodesy.h"
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

/// The anchor as it must be stored so that it does not run out of submaps while releases replace
/// them one by one; nullopt when it can stay as it is.
///
/// Where fewer than three of its submaps are left, near ones join them; those left keep their
/// attachment to the bit, so the anchor does not move. Submaps that are gone keep what places are
/// free, in case they come back. An anchor that nothing holds any more is attached
/// to what held its place in the release `before`, if that is known; if that does not help it stays
/// where it was last seen and is marked unsupported.
std::optional<content::AnchorRecord> RenewSupport(const content::AnchorRecord& record,
                                                  const LiveRelease& live,
                                                  const LiveRelease* before,
                                                  const TangentPlane& map_plane);

}  // namespace waymark::session
