// SPDX-License-Identifier: Apache-2.0
#include "session/rehearsal/moved_anchors.h"

#include <algorithm>

#include "session/state/carrying.h"

namespace waymark::session {
namespace {

constexpr std::size_t kListed = 20;
constexpr std::size_t kPage = 1000;

void List(const MovedAnchor& moved, std::vector<MovedAnchor>& farthest) {
  const auto farther = [](const MovedAnchor& a, const MovedAnchor& b) {
    return a.moved_m > b.moved_m;
  };
  farthest.insert(std::upper_bound(farthest.begin(), farthest.end(), moved, farther), moved);
  if (farthest.size() > kListed) farthest.pop_back();
}

/// Looks at one anchor after the other.
class Comparison {
 public:
  Comparison(const std::shared_ptr<const LiveRelease>& live,
             const std::shared_ptr<const LiveRelease>& candidate, const LoadRelease& load,
             const TangentPlane& map_plane, double limit_m)
      : live_(live),
        candidate_(candidate),
        history_(candidate, live, load),
        map_plane_(map_plane),
        limit_m_(limit_m) {}

  void Look(const content::AnchorRecord& record) {
    const RoomAnchor now = CarryAnchor(record, live_->release.epoch, live_->placements);
    const auto renewed = RenewSupport(record, history_, map_plane_).value_or(record);
    const RoomAnchor then = CarryAnchor(renewed, candidate_->release.epoch, candidate_->placements);
    const Transform<Map, Anchor>& from = now.record.map_from_anchor;
    const Transform<Map, Anchor>& to = then.record.map_from_anchor;
    const MovedAnchor moved{record.room, record.id, (to.translation() - from.translation()).norm(),
                            from.rotation().angularDistance(to.rotation())};
    ++moves_.anchors;
    if (moved.moved_m >= 0.01) {
      ++moves_.moved_by_1cm;
      List(moved, moves_.farthest);
    }
    if (moved.moved_m > limit_m_) ++moves_.beyond_limit;
    if (now.is_supported && !then.is_supported) {
      ++moves_.losing_support;
      if (moves_.lost.size() < kListed) moves_.lost.push_back(moved);
    }
  }
  AnchorMoves Moves() && { return std::move(moves_); }

 private:
  const std::shared_ptr<const LiveRelease> live_, candidate_;
  ReleaseHistory history_;
  const TangentPlane map_plane_;
  const double limit_m_;
  AnchorMoves moves_;
};

}  // namespace

Result<AnchorMoves> CompareAnchors(content::AnchorStore& store,
                                   const std::shared_ptr<const LiveRelease>& live,
                                   const std::shared_ptr<const LiveRelease>& candidate,
                                   const LoadRelease& load, const TangentPlane& map_plane,
                                   double limit_m) {
  Comparison comparison(live, candidate, load, map_plane, limit_m);
  WAYMARK_TRY_ASSIGN(const auto rooms, store.ListRooms());
  for (const content::RoomSummary& room : rooms) {
    content::AnchorQuery query{.room = room.room, .limit = kPage};
    while (true) {
      WAYMARK_TRY_ASSIGN(const content::AnchorPage page, store.Query(query));
      for (const content::AnchorRecord& record : page.anchors) comparison.Look(record);
      if (!page.next) break;
      query.after = page.next;
    }
  }
  return std::move(comparison).Moves();
}

}  // namespace waymark::session
