// SPDX-License-Identifier: Apache-2.0
#include "session/device/room_view.h"

#include <gmock/gmock.h>

namespace waymark::session {
namespace {

using std::chrono::seconds;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr RunId kRun{1}, kNextRun{2};
const ServerTime kNow{seconds(1000)};

AnchorId AnchorNamed(int number) {
  return AnchorId(FormatUuid(UuidFromBits(1, static_cast<std::uint64_t>(number))));
}
AnchorState State(int number, std::uint64_t revision, RunId run = kRun) {
  AnchorState state{run, {.record = {.id = AnchorNamed(number), .room = RoomId("")}}};
  state.anchor.record.revision = revision;
  return state;
}
RoomState RoomOf(std::initializer_list<std::pair<int, std::uint64_t>> anchors, RunId run = kRun) {
  RoomState room{.room = RoomId("square"), .run = run};
  for (const auto& [number, revision] : anchors) {
    ++room.anchor_count;
    room.anchor_digest ^= AnchorDigest(AnchorNamed(number), revision);
  }
  return room;
}

AnchorState Own(int number, std::uint64_t revision, RunId run = kRun) {
  AnchorState state = State(number, revision, run);
  state.anchor.record.visibility = content::AnchorVisibility::kPrivate;
  return state;
}
OwnerState OwnOf(int number, std::uint64_t revision) {
  return {.owner = "@anna",
          .run = kRun,
          .anchor_count = 1,
          .anchor_digest = AnchorDigest(AnchorNamed(number), revision)};
}

OwnerState OwnNone(RunId run = kRun) { return {.owner = "@anna", .run = run}; }

class View : public testing::Test {
 protected:
  View() {
    view_.StartRun(kRun, 1);
    view_.On(OwnNone());
  }

  std::vector<std::string> Ids() const {
    std::vector<std::string> ids;
    for (const SharedAnchor& anchor : view_.Anchors()) ids.push_back(anchor.id.text());
    return ids;
  }

  const DeviceId self_{"self"}, ben_{"ben"};
  RoomView view_{self_};
};

TEST_F(View, WaitsForItsOwnersAnchors) {
  RoomView view(self_);
  view.StartRun(kRun, 1);
  view.On(RoomOf({{1, 10}}));
  view.On(State(1, 10));
  EXPECT_FALSE(view.HasSnapshot());
  view.On(OwnOf(2, 11));
  EXPECT_FALSE(view.HasSnapshot());
  view.On(Own(2, 11));
  EXPECT_TRUE(view.HasSnapshot());
  EXPECT_THAT(view.Anchors(), SizeIs(2));
  view.OnGone(AnchorNamed(2), true);
  EXPECT_THAT(view.Anchors(), SizeIs(1));
}

TEST_F(View, AnAnchorThatChangesItsAudienceIsThereOnceWhicheverIsToldFirst) {
  view_.On(Own(1, 10));
  view_.On(State(1, 11));
  EXPECT_THAT(Ids(), SizeIs(1));
  EXPECT_EQ(view_.FindAnchor(AnchorNamed(1))->revision, 11u);
  view_.OnGone(AnchorNamed(1), true);
  EXPECT_THAT(Ids(), SizeIs(1));
  view_.OnGone(AnchorNamed(1), false);
  view_.On(Own(1, 12));
  EXPECT_EQ(view_.FindAnchor(AnchorNamed(1))->audience, content::AnchorVisibility::kPrivate);
}

TEST_F(View, IsCompleteWhenCountAndDigestAgreeInAnyOrder) {
  EXPECT_FALSE(view_.HasSnapshot());
  view_.On(State(1, 10));
  view_.On(RoomOf({{1, 10}, {2, 12}}));
  EXPECT_FALSE(view_.HasSnapshot());
  view_.On(State(2, 11));
  EXPECT_FALSE(view_.HasSnapshot()) << "the right count, but an old revision";
  view_.On(State(2, 12));
  EXPECT_TRUE(view_.HasSnapshot());
  view_.On(State(3, 13));
  EXPECT_TRUE(view_.HasSnapshot()) << "from then on changes just arrive";
  EXPECT_THAT(Ids(), SizeIs(3));
}

TEST_F(View, AnEmptyRoomIsComplete) {
  view_.On(RoomOf({}));
  EXPECT_TRUE(view_.HasSnapshot());
}

TEST_F(View, OlderRevisionsDoNotReturn) {
  view_.OnOwnChange(State(1, 12).anchor);
  view_.On(State(1, 10));
  EXPECT_EQ(view_.Anchors()[0].revision, 12u);
  view_.OnGone(AnchorNamed(1));
  view_.OnOwnChange(State(1, 12).anchor);
  EXPECT_THAT(view_.Anchors(), IsEmpty()) << "a late answer does not raise the dead";
}

// run 1   anchors 1 2         server gone, 2 deleted
// run 2                       anchor 1, state {1}: complete, and 2 is dropped
TEST_F(View, ANewRunKeepsTheOldAnchorsUntilItIsComplete) {
  view_.On(State(1, 10));
  view_.On(State(2, 11));
  view_.On(RoomOf({{1, 10}, {2, 11}}));
  ASSERT_TRUE(view_.HasSnapshot());
  view_.On(State(1, 10, kNextRun));  // before its welcome
  view_.StartRun(kNextRun, 1);
  EXPECT_FALSE(view_.HasSnapshot());
  EXPECT_THAT(Ids(), SizeIs(2)) << "content does not flicker";
  view_.On(RoomOf({{1, 10}}, kNextRun));
  view_.On(OwnNone(kNextRun));
  EXPECT_TRUE(view_.HasSnapshot());
  EXPECT_THAT(Ids(), ElementsAre(AnchorNamed(1).text()));
}

// The same run, but a silence so long that the deletion of 2 is no longer told.
TEST_F(View, AfterALongSilenceWhatIsNotDeliveredAnewIsOver) {
  view_.On(State(1, 10));
  view_.On(State(2, 11));
  view_.On(RoomOf({{1, 10}, {2, 11}}));
  view_.BeginResync();
  EXPECT_TRUE(view_.HasSnapshot()) << "nothing says otherwise yet";
  view_.On(RoomOf({{1, 10}}));
  view_.On(State(1, 10));
  EXPECT_TRUE(view_.HasSnapshot());
  EXPECT_THAT(Ids(), ElementsAre(AnchorNamed(1).text()));
}

// The same one by one, as DDS tells it: some of it perhaps after what is told anew.
TEST_F(View, WhatIsLostIsOverUnlessItIsToldAnew) {
  view_.On(State(1, 10));
  view_.On(State(2, 11));
  view_.On(Own(3, 12));
  view_.On(OwnOf(3, 12));
  view_.On(RoomOf({{1, 10}, {2, 11}}));
  view_.On(Presence{ben_, DeviceNumber{5}, "Ben", kRun});
  for (const int number : {1, 2}) view_.OnLost(AnchorNamed(number), false);
  view_.OnLost(AnchorNamed(3), true);
  view_.OnLost(AnchorNamed(4), false);
  view_.OnLost(DeviceId("nobody"));
  EXPECT_TRUE(view_.HasSnapshot()) << "nothing says otherwise yet";
  EXPECT_THAT(Ids(), SizeIs(3)) << "content does not flicker";
  EXPECT_TRUE(view_.Others(kNow)[0].is_present);
  view_.OnLost(ben_);
  EXPECT_FALSE(view_.Others(kNow)[0].is_present);
  view_.On(Presence{ben_, DeviceNumber{5}, "Ben", kRun});
  EXPECT_TRUE(view_.Others(kNow)[0].is_present);
  view_.On(State(1, 10));
  view_.On(RoomOf({{1, 10}}));
  view_.On(OwnNone());
  EXPECT_TRUE(view_.HasSnapshot());
  EXPECT_THAT(Ids(), ElementsAre(AnchorNamed(1).text()));
}

TEST_F(View, OthersComeMoveAndGo) {
  const auto pose = [&](double x, ServerTime time, RunId run = kRun) {
    return PoseBatch{.run = run,
                     .poses = {{DeviceNumber{5},
                                {.time = time,
                                 .map_from_device = {Eigen::Quaterniond::Identity(), {x, 0, 0}}}}}};
  };
  view_.On(Presence{self_, DeviceNumber{4}, "me", kRun});
  view_.On(pose(1, kNow), kNow);
  view_.On(Presence{ben_, DeviceNumber{5}, "Ben", kRun});
  ASSERT_THAT(view_.Others(kNow), SizeIs(1)) << "oneself is not another";
  EXPECT_TRUE(view_.Others(kNow)[0].is_present);
  EXPECT_FALSE(view_.Others(kNow)[0].map_from_device) << "the number meant nobody then";
  view_.On(pose(2, kNow), kNow);
  view_.On(pose(3, kNow - seconds(1)), kNow);
  view_.On(pose(4, kNow + seconds(1), kNextRun), kNow);
  const OtherDevice ben = view_.Others(kNow + seconds(2))[0];
  EXPECT_EQ(ben.map_from_device->translation().x(), 2) << "neither late nor of another run";
  EXPECT_EQ(ben.age, seconds(2));
  view_.OnGone(ben_, kNow);
  EXPECT_FALSE(view_.Others(kNow)[0].is_present);
  EXPECT_THAT(view_.Others(kNow + seconds(31)), IsEmpty());
}

/// An anchor at x in the frame of a release, held by submap "a" at 7.
AnchorState AttachedAt(double x, std::uint64_t epoch, std::uint64_t revision) {
  AnchorState state = State(1, revision);
  state.anchor.record.epoch = epoch;
  state.anchor.record.map_from_anchor = {Eigen::Quaterniond::Identity(), {x, 0, 0}};
  state.anchor.record.attachments = {{SubmapId("a"), {Eigen::Quaterniond::Identity(), {7, 0, 0}}}};
  return state;
}

TEST_F(View, AnchorsChangeFrameTogetherWithTheDevice) {
  const Placements moved{{SubmapId("a"), Similarity<Map, Submap>(Sim3(
                                             1, Eigen::Quaterniond::Identity(), {0.5, 0, 0}))}};
  const auto shown_x = [&] { return view_.Anchors()[0].map_from_anchor.translation().x(); };
  view_.On(AttachedAt(7, 1, 10));
  view_.On(AttachedAt(7.5, 2, 10));  // before this device heard of the new release
  EXPECT_EQ(shown_x(), 7);
  EXPECT_EQ(view_.Anchors()[0].epoch, 1u);
  view_.CarryTo(2, moved);
  EXPECT_EQ(shown_x(), 7.5);
  EXPECT_EQ(view_.Anchors()[0].epoch, 2u);

  view_.CarryTo(3, {{SubmapId("a"), Similarity<Map, Submap>(
                                        Sim3(1, Eigen::Quaterniond::Identity(), {-1, 0, 0}))}});
  EXPECT_EQ(shown_x(), 6) << "carried here, before the server's word comes";
  view_.CarryTo(4, {});
  EXPECT_EQ(view_.Anchors()[0].epoch, 3u) << "nothing is known: it waits";
  view_.On(AttachedAt(9, 4, 10));
  EXPECT_EQ(shown_x(), 9);
}

}  // namespace
}  // namespace waymark::session
