// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "content_store/anchor_store.h"
#include "mapping/geometry/geodesy.h"
#include "session/server/anchor_support.h"

namespace waymark::session {

/// An anchor that another release shows elsewhere.
struct MovedAnchor {
  RoomId room;
  AnchorId id;
  double moved_m = 0;
  double turned_rad = 0;
};

/// What becomes of all anchors of a store when a release takes the place of another.
struct AnchorMoves {
  std::size_t anchors = 0;
  std::size_t moved_by_1cm = 0;  ///< or more
  std::size_t beyond_limit = 0;
  std::size_t losing_support = 0;          ///< none of the candidate's submaps holds them
  std::vector<MovedAnchor> farthest = {};  ///< those that move most, at most 20
  std::vector<MovedAnchor> lost = {};      ///< some of those that lose support, at most 20
};

/// Compares where each anchor is shown now with where the candidate would show it, by the rules of
/// a server that swaps (RenewSupport, CarryAnchor). Nothing is written; one page is held at a time.
/// Errors: those of AnchorStore.
Result<AnchorMoves> CompareAnchors(content::AnchorStore& store,
                                   const std::shared_ptr<const LiveRelease>& live,
                                   const std::shared_ptr<const LiveRelease>& candidate,
                                   const LoadRelease& load, const TangentPlane& map_plane,
                                   double limit_m);

}  // namespace waymark::session
