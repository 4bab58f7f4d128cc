// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "session/state/messages.h"

namespace waymark::session {

/// Anchors that one event tells in another release, at most; a few milliseconds on the bus.
inline constexpr std::size_t kCarriedAtOnce = 250;

/// Takes the anchor into the map of a release: carried exactly by the first of its submaps that is
/// still there. If none is, it stays where it was and is unsupported.
void Carry(RoomAnchor& anchor, std::uint64_t epoch, const Placements& placements);
RoomAnchor CarryAnchor(content::AnchorRecord record, std::uint64_t epoch,
                       const Placements& placements);

/// A pose from one release to another, by the first of these submaps that both have; nullopt when
/// there is none.
std::optional<Transform<Map, Anchor>> CarryBetween(const Transform<Map, Anchor>& map_from_anchor,
                                                   std::span<const SubmapId> submaps,
                                                   const Placements& from, const Placements& to);

}  // namespace waymark::session
