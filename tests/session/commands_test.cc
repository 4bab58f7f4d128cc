// SPDX-License-Identifier: Apache-2.0
#include "tests/session/state_fixture.h"

namespace waymark::session {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Commands : public support::StateScript {
 protected:
  static constexpr auto kCreate = AnchorOperation::kCreate;
  static constexpr auto kMove = AnchorOperation::kMove;
  static constexpr auto kDelete = AnchorOperation::kDelete;

  void Send(const AnchorCommand& command) { Play(event::CommandReceived{command}); }
  CommandReply Reply() const { return Only<effect::SendReply>().reply; }

  /// A and B are in the room with anchor 1 at revision 10, A's.
  void OpenWithAnchor() {
    OpenWith("AB");
    Send(Command('A', 1, kCreate, 1));
    StoreApplies(10);
  }
};

TEST_F(Commands, AreWrittenThenPublishedThenAnswered) {
  OpenWith("AB");
  Send(Command('A', 1, kCreate, 1));
  const auto wanted = Only<effect::WriteAnchor>();
  EXPECT_EQ(wanted.record.owner, Device('A').text());
  EXPECT_EQ(wanted.record.room, RoomId("square"));
  EXPECT_TRUE(None<effect::SendReply>() && None<effect::PublishAnchor>()) << "not durable yet";
  StoreApplies(10);
  EXPECT_EQ(Only<effect::PublishAnchor>().state.anchor.record.revision, 10u);
  EXPECT_EQ(Only<effect::PublishRoomState>().state.anchor_count, 1u);
  EXPECT_EQ(Only<effect::PublishRoomState>().state.revision, 10u);
  EXPECT_EQ(Reply().outcome, CommandOutcome::kApplied);
  EXPECT_EQ(Reply().current->record.revision, 10u);
}

TEST_F(Commands, RepetitionsAreAnsweredOnceDone) {
  OpenWith("A");
  Send(Command('A', 1, kCreate, 1));
  const std::vector<Effect> first = effects_;
  Send(Command('A', 1, kCreate, 1));
  EXPECT_THAT(effects_, IsEmpty()) << "it is under way";
  effects_ = first;
  StoreApplies(10);
  Send(Command('A', 1, kCreate, 1));
  EXPECT_TRUE(None<effect::WriteAnchor>());
  EXPECT_EQ(Reply().outcome, CommandOutcome::kApplied);
  EXPECT_EQ(Reply().current->record.revision, 10u);
}

TEST_F(Commands, AnybodyMayMoveByDefaultAndTheOwnerStays) {
  OpenWithAnchor();
  Send(Command('B', 2, kMove, 1, 10, 5));
  EXPECT_EQ(Only<effect::WriteAnchor>().expected_revision, 10u);
  EXPECT_EQ(Only<effect::WriteAnchor>().record.owner, Device('A').text());
  EXPECT_EQ(Only<effect::WriteAnchor>().record.payload, "p");
  StoreApplies(11);
  EXPECT_EQ(Reply().current->record.map_from_anchor.translation().x(), 5);
}

TEST_F(Commands, OwnersCanKeepTheirAnchorsToThemselves) {
  options_.rights = AnchorRights::kOwner;
  state_ = SessionState(options_, RunId{42}, map_);
  OpenWithAnchor();
  Send(Command('B', 2, kMove, 1, 10, 5));
  EXPECT_EQ(Reply().outcome, CommandOutcome::kInvalid);
  EXPECT_THAT(Reply().reason, HasSubstr("belongs to"));
  Send(Command('A', 3, kMove, 1, 10, 5));
  EXPECT_FALSE(None<effect::WriteAnchor>());
}

TEST_F(Commands, AStaleRevisionIsAConflictWithWhatStands) {
  OpenWithAnchor();
  Send(Command('B', 2, kMove, 1, 9, 5));
  EXPECT_EQ(Reply().outcome, CommandOutcome::kConflict);
  EXPECT_EQ(Reply().current->record.revision, 10u);
  EXPECT_TRUE(None<effect::WriteAnchor>());
}

TEST_F(Commands, TheStoreHasTheLastWord) {
  OpenWithAnchor();
  Send(Command('B', 2, kMove, 1, 10, 5));
  RoomAnchor other{.record = Only<effect::WriteAnchor>().record};
  other.record.map_from_anchor = {Eigen::Quaterniond::Identity(), {7, 0, 0}};
  other.record.revision = 12;
  StoreRefuses(other);
  EXPECT_EQ(Reply().outcome, CommandOutcome::kConflict);
  Send(Command('B', 3, kDelete, 1, 10));
  StoreRefuses(std::nullopt);
  EXPECT_EQ(Reply().outcome, CommandOutcome::kNotFound);
}

// The first run was acknowledged to nobody: the server went away in between.
TEST_F(Commands, ARepetitionThatFindsItsOwnWorkIsNoConflict) {
  OpenWithAnchor();
  Send(Command('A', 2, kMove, 1, 9, 0));
  EXPECT_EQ(Reply().outcome, CommandOutcome::kApplied);
  Send(Command('A', 3, kCreate, 1));
  EXPECT_EQ(Reply().outcome, CommandOutcome::kApplied);
  EXPECT_EQ(Reply().current->record.revision, 10u);
  Send(Command('B', 4, kCreate, 1));
  EXPECT_EQ(Reply().outcome, CommandOutcome::kConflict) << "it is not B's work";
}

TEST_F(Commands, DeletionIsPublishedAsTheEnd) {
  OpenWithAnchor();
  Send(Command('B', 2, kDelete, 1, 10));
  StoreApplies(11);
  EXPECT_EQ(Only<effect::WithdrawAnchor>().anchor, AnchorNamed(1));
  EXPECT_EQ(Only<effect::PublishRoomState>().state.anchor_count, 0u);
  EXPECT_EQ(Only<effect::PublishRoomState>().state.anchor_digest, 0u);
  EXPECT_EQ(Reply().outcome, CommandOutcome::kApplied);
  Send(Command('A', 3, kMove, 1, 11));
  EXPECT_EQ(Reply().outcome, CommandOutcome::kNotFound);
}

TEST_F(Commands, AFailingStoreIsNotRemembered) {
  OpenWith("A");
  Send(Command('A', 1, kCreate, 1));
  Play(event::WriteFinished{Only<effect::WriteAnchor>().write,
                            MakeError(ErrorCode::kUnavailable, "disk full")});
  EXPECT_EQ(Reply().outcome, CommandOutcome::kUnavailable);
  EXPECT_THAT(Reply().reason, HasSubstr("disk full"));
  EXPECT_TRUE(None<effect::PublishAnchor>());
  Send(Command('A', 1, kCreate, 1));
  EXPECT_FALSE(None<effect::WriteAnchor>()) << "the repetition may fare better";
}

TEST_F(Commands, APoseInAnotherEpochIsAConflict) {
  OpenWith("A");
  AnchorCommand command = Command('A', 1, kCreate, 1);
  command.epoch = 2;
  Send(command);
  EXPECT_EQ(Reply().outcome, CommandOutcome::kConflict);
  EXPECT_THAT(Reply().reason, HasSubstr("epoch 2"));
}

TEST_F(Commands, LimitsHold) {
  options_.max_anchors = 1;
  options_.max_writes_per_device = 2;
  state_ = SessionState(options_, RunId{42}, map_);
  OpenWithAnchor();
  Send(Command('A', 2, kCreate, 2));
  EXPECT_EQ(Reply().outcome, CommandOutcome::kInvalid);
  Send(Command('A', 3, kMove, 1, 10, 1));
  Send(Command('A', 4, kMove, 1, 10, 2));
  Send(Command('A', 5, kMove, 1, 10, 3));
  EXPECT_EQ(Reply().outcome, CommandOutcome::kUnavailable);
}

TEST_F(Commands, WhatWasWrittenStaysWhenItsAuthorLeaves) {
  OpenWith("AB");
  Send(Command('A', 1, kCreate, 1));
  const std::vector<Effect> wanted = effects_;
  Play(event::DeviceLeft{Device('A')});
  effects_ = wanted;
  StoreApplies(10);
  EXPECT_FALSE(None<effect::PublishAnchor>());
  EXPECT_TRUE(None<effect::SendReply>());
}

TEST_F(Commands, StrangersCommandsAreIgnored) {
  OpenWith("A");
  Send(Command('X', 1, kCreate, 1));
  EXPECT_THAT(effects_, IsEmpty());
}

TEST_F(Commands, TheDigestIsThatOfTheAnchors) {
  OpenWithAnchor();
  Send(Command('A', 2, kCreate, 2));
  StoreApplies(11);
  Send(Command('A', 3, kMove, 1, 10, 4));
  StoreApplies(12);
  const RoomState state = Only<effect::PublishRoomState>().state;
  EXPECT_EQ(state.anchor_digest,
            AnchorDigest(AnchorNamed(1), 12) ^ AnchorDigest(AnchorNamed(2), 11));
  EXPECT_EQ(state.anchor_count, 2u);
  EXPECT_EQ(state.revision, 12u);
}

}  // namespace
}  // namespace waymark::session
