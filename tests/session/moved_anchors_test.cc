// SPDX-License-Identifier: Apache-2.0
// Where another release would show anchors.
#include "session/rehearsal/moved_anchors.h"

#include <gmock/gmock.h>

#include "tests/support/memory_anchor_store.h"

namespace waymark::session {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

const TangentPlane kMapPlane({Angle::Degrees(52.5), Angle::Degrees(13.4), 80});

/// Submaps along a street, 20 m apart, each shifted north by so much.
std::shared_ptr<const LiveRelease> Street(std::uint64_t epoch,
                                          const std::map<std::string, double>& north_m) {
  mapping::Release release;
  release.epoch = epoch;
  if (epoch > 1) release.parent_epoch = epoch - 1;
  for (const auto& [name, shift_m] : north_m) {
    const Eigen::Vector3d centre(20.0 * (name.front() - 'a'), shift_m, 0);
    release.submaps.push_back({.id = SubmapId(name),
                               .map_from_submap = Similarity<Map, Submap>(
                                   Sim3(1, Eigen::Quaterniond::Identity(), centre)),
                               .centre = Point<Map>(centre),
                               .radius_m = 20,
                               .displacement = std::nullopt});
  }
  return std::make_shared<const LiveRelease>(std::move(release));
}

class MovedAnchors : public testing::Test {
 protected:
  void Place(const std::string& id, double east_m, const LiveRelease& live) {
    content::AnchorRecord record{.id = AnchorId("00000000-0000-4000-8000-00000000000" + id),
                                 .room = RoomId("square")};
    record.map_from_anchor = {Eigen::Quaterniond::Identity(), {east_m, 0, 1}};
    record.epoch = live.release.epoch;
    record.place = kMapPlane.ToGeo(Point<Map>(record.map_from_anchor.translation()));
    record.attachments = AttachToSubmaps(record.map_from_anchor, {}, live.release);
    ASSERT_TRUE(store_.Create(record).ok());
  }
  AnchorMoves Compare(const std::shared_ptr<const LiveRelease>& live,
                      const std::shared_ptr<const LiveRelease>& candidate) {
    return *CompareAnchors(store_, live, candidate, {}, kMapPlane, 0.1);
  }

  support::MemoryAnchorStore store_;
};

TEST_F(MovedAnchors, MoveWithTheSubmapThatHoldsThemAndAreListedByHowFar) {
  const auto live = Street(1, {{"a", 0}, {"b", 0}, {"c", 0}});
  Place("1", 0, *live);
  Place("2", 20, *live);
  Place("3", 40, *live);
  const AnchorMoves moves = Compare(live, Street(2, {{"a", 0}, {"b", 0.05}, {"c", 0.3}}));
  EXPECT_EQ(moves.anchors, 3u);
  EXPECT_EQ(moves.moved_by_1cm, 2u);
  EXPECT_EQ(moves.beyond_limit, 1u);
  EXPECT_EQ(moves.losing_support, 0u);
  ASSERT_THAT(moves.farthest, SizeIs(2));
  EXPECT_NEAR(moves.farthest[0].moved_m, 0.3, 1e-9);
  EXPECT_NEAR(moves.farthest[1].moved_m, 0.05, 1e-9);
}

TEST_F(MovedAnchors, StayWhereOthersHoldThemWhenASubmapGoes) {
  const auto live = Street(1, {{"a", 0}, {"b", 0}, {"c", 0}});
  Place("1", 0, *live);
  const AnchorMoves moves = Compare(live, Street(2, {{"b", 0}, {"c", 0}}));
  EXPECT_EQ(moves.moved_by_1cm, 0u);
  EXPECT_EQ(moves.losing_support, 0u);
}

TEST_F(MovedAnchors, ThatLoseAllTheirSubmapsAreNamed) {
  const auto live = Street(1, {{"a", 0}, {"b", 0}, {"c", 0}});
  Place("1", 0, *live);
  const AnchorMoves moves = Compare(live, Street(2, {{"z", 0}}));
  EXPECT_EQ(moves.losing_support, 1u);
  ASSERT_THAT(moves.lost, SizeIs(1));
  EXPECT_EQ(moves.lost[0].room, RoomId("square"));
  EXPECT_THAT(store_.LoadRoom(RoomId("square"))->anchors[0].unsupported_since_epoch,
              testing::Eq(std::nullopt))
      << "nothing is written";
}

TEST_F(MovedAnchors, OfAnEmptyStoreAreNone) {
  const auto live = Street(1, {{"a", 0}});
  EXPECT_THAT(Compare(live, live).farthest, IsEmpty());
}

}  // namespace
}  // namespace waymark::session
