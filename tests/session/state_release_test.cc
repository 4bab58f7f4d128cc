// SPDX-License-Identifier: Apache-2.0
#include "session/state/carrying.h"
#include "tests/session/state_fixture.h"

namespace waymark::session {
namespace {

using testing::ElementsAre;
using testing::Key;

Placements At(double east_m) {
  return {{SubmapId("a"),
           Similarity<Map, Submap>(Sim3(1, Eigen::Quaterniond::Identity(), {east_m, 0, 0}))},
          {SubmapId("b"),
           Similarity<Map, Submap>(Sim3(1, Eigen::Quaterniond::Identity(), {0, east_m, 0}))}};
}

class StateRelease : public support::StateScript {
 protected:
  StateRelease() {
    state_ = SessionState(options_, RunId{42}, map_, std::make_shared<const Placements>(At(0)));
  }
  void Swap(std::uint64_t epoch, const Placements& placements) {
    Play(event::ReleaseSwapped{epoch, std::make_shared<const Placements>(placements)});
  }
  /// An anchor at x, y = 0 in release 1, attached to these submaps.
  static RoomAnchor Anchor(int number, double x, const std::vector<std::string>& submaps) {
    RoomAnchor anchor{.record = {.id = AnchorNamed(number), .room = RoomId("square")}};
    anchor.record.epoch = 1;
    anchor.record.map_from_anchor = {Eigen::Quaterniond::Identity(), {x, 0, 0}};
    for (const std::string& submap : submaps) {
      anchor.record.attachments.push_back(
          {SubmapId(submap), {Eigen::Quaterniond::Identity(), {x, 0, 0}}});
    }
    return anchor;
  }
  static double X(const RoomAnchor& anchor) {
    return anchor.record.map_from_anchor.translation().x();
  }
};

TEST_F(StateRelease, AnchorsAreCarriedAndWhatCarriesThemIsTold) {
  Hello('a');
  LoadRoom("square", {Anchor(1, 7, {"a"}), Anchor(2, 8, {"gone"})});
  Play(event::Localised{Device('a'), SubmapId("b")});
  Pose('a', 3);
  Swap(2, At(0.5));
  const auto map = Only<effect::PublishMapState>().state;
  EXPECT_EQ(map.epoch, 2u);
  EXPECT_EQ(map.swap, 1u);
  EXPECT_THAT(map.placements, ElementsAre(Key(SubmapId("a")), Key(SubmapId("b"))));
  const auto anchors = All<effect::PublishAnchor>();
  ASSERT_EQ(anchors.size(), 2u);
  EXPECT_DOUBLE_EQ(X(anchors[0].state.anchor), 7.5);
  EXPECT_TRUE(anchors[0].state.anchor.is_supported);
  EXPECT_DOUBLE_EQ(X(anchors[1].state.anchor), 8) << "it is not moved by guesswork";
  EXPECT_FALSE(anchors[1].state.anchor.is_supported);
  EXPECT_EQ(Only<effect::PublishRoomState>().state.epoch, 2u);
  const auto report = Only<effect::ReportSwap>();
  EXPECT_EQ(report.carried, 1u);
  EXPECT_EQ(report.unsupported, 1u);
  EXPECT_DOUBLE_EQ(report.max_motion_m, 0.5);
  Wait(std::chrono::seconds(1));
  Play(event::Ticked{});
  EXPECT_TRUE(None<effect::PublishPoses>()) << "poses of the old frame are not shared";
  Pose('a', 3, 2);
  Play(event::Ticked{});
  EXPECT_EQ(Only<effect::PublishPoses>().poses.size(), 1u);
}

TEST_F(StateRelease, ThereAndBackIsExact) {
  Hello('a');
  LoadRoom("square", {Anchor(1, 7, {"a"})});
  Swap(2, At(0.3));
  Swap(3, At(-0.7));
  Swap(1, At(0));
  EXPECT_EQ(X(Only<effect::PublishAnchor>().state.anchor), 7);
  EXPECT_EQ(Only<effect::PublishMapState>().state.swap, 3u);
}

TEST_F(StateRelease, TheSameReleaseAgainIsNoNews) {
  OpenWith("a");
  Swap(1, At(9));
  EXPECT_TRUE(effects_.empty());
}

TEST_F(StateRelease, WhatTheStoreReadOrWroteBeforeIsCarried) {
  Hello('a');
  Swap(2, At(0.5));
  LoadRoom("square", {Anchor(1, 7, {"a"})});
  EXPECT_DOUBLE_EQ(X(Only<effect::PublishAnchor>().state.anchor), 7.5);

  auto command = Command('a', 1, AnchorOperation::kCreate, 2, 0, 4);
  command.epoch = 2;
  Play(event::CommandReceived{command});
  const auto wanted = Only<effect::WriteAnchor>();
  Swap(3, At(1));
  RoomAnchor written{.record = wanted.record, .is_supported = true};
  written.record.attachments = {{SubmapId("a"), {Eigen::Quaterniond::Identity(), {3.5, 0, 0}}}};
  written.record.revision = 9;
  Play(event::WriteFinished{wanted.write, event::WriteFinished::Applied{written}});
  EXPECT_DOUBLE_EQ(X(Only<effect::PublishAnchor>().state.anchor), 4.5);
  EXPECT_DOUBLE_EQ(X(*Only<effect::SendReply>().reply.current), 4.5);
}

TEST_F(StateRelease, ARoomThatIsReadInPartsIsAllOfTheLiveRelease) {
  Hello('a');
  Play(event::RoomPartLoaded{RoomId("square"), {Anchor(1, 7, {"a"})}});
  EXPECT_EQ(All<effect::OpenRoom>().size(), 1u);
  EXPECT_EQ(All<effect::PublishAnchor>().size(), 1u);
  Swap(2, At(0.5));
  EXPECT_DOUBLE_EQ(X(Only<effect::PublishAnchor>().state.anchor), 7.5) << "read before the swap";
  Play(event::RoomPartLoaded{RoomId("square"), {Anchor(2, 8, {"a"})}});
  EXPECT_TRUE(None<effect::SendWelcome>());
  LoadRoom("square", {Anchor(3, 9, {"a"})});
  EXPECT_TRUE(None<effect::OpenRoom>());
  EXPECT_DOUBLE_EQ(X(Only<effect::PublishAnchor>().state.anchor), 9.5);
  EXPECT_EQ(Only<effect::PublishRoomState>().state.anchor_count, 3u);
  EXPECT_EQ(Only<effect::SendWelcome>().welcome.verdict, JoinVerdict::kAccepted);
}

TEST_F(StateRelease, CommandsOfTheReleaseBeforeAreUnderstoodOlderOnesAreNot) {
  OpenWith("a");
  Swap(2, At(0.5));
  auto command = Command('a', 1, AnchorOperation::kCreate, 1, 0, 4);
  command.seen_in = {SubmapId("unknown"), SubmapId("a")};
  Play(event::CommandReceived{command});
  const auto wanted = Only<effect::WriteAnchor>();
  EXPECT_EQ(wanted.record.epoch, 2u);
  EXPECT_DOUBLE_EQ(wanted.record.map_from_anchor.translation().x(), 4.5);

  command.request = Request(2);
  command.anchor = AnchorNamed(2);
  command.seen_in = {SubmapId("unknown")};
  Play(event::CommandReceived{command});
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kConflict);
  Swap(3, At(1));
  command.request = Request(3);
  command.seen_in = {SubmapId("a")};
  Play(event::CommandReceived{command});
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kConflict);
}

}  // namespace
}  // namespace waymark::session
