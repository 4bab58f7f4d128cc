// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "session/state/messages.h"

namespace waymark::session {

/// The anchor in the map of a release: carried exactly by the first of its submaps that is still
/// there. If none is, it stays where it was and is unsupported.
RoomAnchor CarryAnchor(const content::AnchorRecord& record, std::uint64_t epoch,
                       const Placements& placements);

/// A pose from one release to another, by the first of these submaps that both have; nullopt when
/// there is none.
std::optional<Transform<Map, Anchor>> CarryBetween(const Transform<Map, Anchor>& map_from_anchor,
                                                   std::span<const SubmapId> submaps,
                                                   const Placements& from, const Placements& to);

}  // namespace waymark::session
