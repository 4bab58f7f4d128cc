// SPDX-License-Identifier: Apache-2.0
// Anchors that others write, as the store's change feed tells them.
#include "tests/session/state_fixture.h"

namespace waymark::session {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

class Following : public support::StateScript {
 protected:
  static content::AnchorRecord Record(int number, std::uint64_t revision, double x = 0) {
    content::AnchorRecord record{.id = AnchorNamed(number), .room = RoomId("square")};
    record.owner = Device('a').text();
    record.map_from_anchor = {Eigen::Quaterniond::Identity(), {x, 0, 0}};
    record.revision = revision;
    return record;
  }
  static content::AnchorChange Change(const content::AnchorRecord& record) {
    return {record.revision, record.id, record.room, record};
  }
  static content::AnchorChange Deletion(int number, std::uint64_t revision) {
    return {revision, AnchorNamed(number), RoomId("square"), std::nullopt};
  }
  void Tell(const content::AnchorRecord& record) { Play(event::StoreChanged{{Change(record)}}); }
  void Tell(int number, std::uint64_t revision) { Tell(Record(number, revision)); }
  void TellDeletion(int number, std::uint64_t revision) {
    Play(event::StoreChanged{{Deletion(number, revision)}});
  }
};

TEST_F(Following, PublishesWhatAnotherServerWrote) {
  OpenWith("a");
  Tell(1, 5);
  EXPECT_EQ(Only<effect::PublishAnchor>().state.anchor.record.revision, 5u);
  const RoomState with_one = Only<effect::PublishRoomState>().state;
  EXPECT_EQ(with_one.anchor_count, 1u);
  EXPECT_EQ(with_one.revision, 5u);
  TellDeletion(1, 6);
  EXPECT_EQ(Only<effect::WithdrawAnchor>().anchor, AnchorNamed(1));
  EXPECT_EQ(Only<effect::PublishRoomState>().state.anchor_digest, 0u);
  TellDeletion(1, 6);
  EXPECT_THAT(effects_, IsEmpty()) << "told once";
}

TEST_F(Following, ManyChangesAreOneStateOfTheRoom) {
  OpenWith("a");
  Play(event::StoreChanged{{Change(Record(1, 5)), Change(Record(2, 6)), Deletion(1, 8)}});
  EXPECT_THAT(All<effect::PublishAnchor>(), SizeIs(2));
  EXPECT_THAT(All<effect::WithdrawAnchor>(), SizeIs(1));
  EXPECT_EQ(Only<effect::PublishRoomState>().state.anchor_count, 1u);
}

TEST_F(Following, IgnoresRoomsThatNobodyIsIn) {
  Tell(1, 5);
  EXPECT_THAT(effects_, IsEmpty());
}

TEST_F(Following, TellsOwnWritesOnceWhicheverComesFirst) {
  OpenWith("a");
  Play(event::CommandReceived{Command('a', 1, AnchorOperation::kCreate, 1)});
  StoreApplies(5);
  Tell(1, 5);
  EXPECT_THAT(effects_, IsEmpty());
  Play(event::CommandReceived{Command('a', 2, AnchorOperation::kMove, 1, 5, 3)});
  const auto move = Only<effect::WriteAnchor>();
  Tell(1, 6);  // the feed is faster than the answer
  EXPECT_FALSE(None<effect::PublishAnchor>());
  RoomAnchor moved{.record = move.record};
  moved.record.revision = 6;
  Play(event::WriteFinished{move.write, event::WriteFinished::Applied{moved}});
  EXPECT_TRUE(None<effect::PublishAnchor>());
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kApplied);
}

TEST_F(Following, AnOldAnswerDoesNotBringBackWhatAnotherServerDeleted) {
  OpenWith("a");
  Play(event::CommandReceived{Command('a', 1, AnchorOperation::kCreate, 1)});
  const auto create = Only<effect::WriteAnchor>();
  Tell(1, 5);
  TellDeletion(1, 6);
  RoomAnchor created{.record = create.record};
  created.record.revision = 5;
  Play(event::WriteFinished{create.write, event::WriteFinished::Applied{created}});
  EXPECT_TRUE(None<effect::PublishAnchor>());
  Hello('b');
  Play(event::CommandReceived{Command('b', 2, AnchorOperation::kDelete, 1, 5)});
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kNotFound);
}

TEST_F(Following, AnOldChangeDoesNotBringBackWhatWasDeletedHere) {
  OpenWith("a");
  Tell(1, 5);
  Play(event::CommandReceived{Command('a', 1, AnchorOperation::kDelete, 1, 5)});
  StoreApplies(7);
  Tell(1, 6);  // what another server had written before, told late
  EXPECT_TRUE(None<effect::PublishAnchor>());
  TellDeletion(1, 7);
  EXPECT_THAT(effects_, IsEmpty());
}

TEST_F(Following, ChangesDuringTheReadingOfARoomAreNotLost) {
  Hello('a');
  Tell(1, 5);
  Tell(2, 6);
  EXPECT_THAT(effects_, IsEmpty());
  Play(event::RoomLoaded{RoomId("square"), std::uint64_t{5}, {RoomAnchor{Record(1, 5)}}});
  EXPECT_THAT(All<effect::PublishAnchor>(), SizeIs(2)) << "one read, one told after it";
  EXPECT_EQ(Only<effect::PublishRoomState>().state.revision, 6u);
}

TEST_F(Following, WhatComesFromAnotherReleaseIsShownInTheLiveOne) {
  const auto placements = [](double east_m) {
    return std::make_shared<const Placements>(Placements{
        {SubmapId("s"),
         Similarity<Map, Submap>(Sim3(1, Eigen::Quaterniond::Identity(), {east_m, 0, 0}))}});
  };
  state_ = SessionState(options_, RunId{42}, map_, placements(0));
  OpenWith("a");
  content::AnchorRecord record = Record(1, 5, 7);
  record.attachments = {{SubmapId("s"), Transform<Submap, Anchor>(record.map_from_anchor.rigid())}};
  Play(event::ReleaseSwapped{2, placements(0.5)});
  Tell(record);  // of a server that still serves release 1
  const RoomAnchor shown = Only<effect::PublishAnchor>().state.anchor;
  EXPECT_EQ(shown.record.epoch, 2u);
  EXPECT_DOUBLE_EQ(shown.record.map_from_anchor.translation().x(), 7.5);
  EXPECT_TRUE(shown.is_supported);
  record.revision = 6;
  record.epoch = 3;  // of one that went over already
  record.map_from_anchor = {Eigen::Quaterniond::Identity(), {9, 0, 0}};
  Tell(record);
  EXPECT_DOUBLE_EQ(
      Only<effect::PublishAnchor>().state.anchor.record.map_from_anchor.translation().x(), 7.5);
  record.revision = 7;
  record.attachments = {
      {SubmapId("gone"), Transform<Submap, Anchor>(record.map_from_anchor.rigid())}};
  Tell(record);
  EXPECT_FALSE(Only<effect::PublishAnchor>().state.anchor.is_supported);
}

// ---- attached anew ----------------------------------------------------------------------------

TEST_F(Following, WhoKnowsAnAnchorBeforeItWasAttachedAnewKnowsItStill) {
  OpenWith("a");
  Tell(Record(1, 5, 3));
  content::AnchorRecord renewed = Record(1, 6, 3);
  renewed.attachments = {
      {SubmapId("new"), Transform<Submap, Anchor>(renewed.map_from_anchor.rigid())}};
  Tell(renewed);
  Tell(Record(1, 7, 3));
  Play(event::CommandReceived{Command('a', 1, AnchorOperation::kMove, 1, 5, 4)});
  EXPECT_EQ(Only<effect::WriteAnchor>().expected_revision, 7u);
  StoreApplies(8);
  Play(event::CommandReceived{Command('a', 2, AnchorOperation::kMove, 1, 7, 9)});
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kConflict)
      << "it was moved since";
  Play(event::CommandReceived{Command('a', 3, AnchorOperation::kDelete, 1, 4)});
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kConflict)
      << "older than what is the same";
}

// ---- who may see and edit ---------------------------------------------------------------------

TEST_F(Following, WhatIsPrivateIsNeverSentToTheRoom) {
  content::AnchorRecord secret = Record(1, 4);
  secret.visibility = content::AnchorVisibility::kPrivate;
  Hello('a');
  Play(event::RoomLoaded{RoomId("square"), std::uint64_t{4}, {RoomAnchor{secret}}});
  EXPECT_TRUE(None<effect::PublishAnchor>());
  EXPECT_EQ(Only<effect::PublishRoomState>().state.anchor_count, 0u);
  secret.revision = 5;
  Tell(secret);
  EXPECT_TRUE(None<effect::PublishAnchor>());
  EXPECT_TRUE(None<effect::WithdrawAnchor>());

  // Its id is taken all the same, as one that was deleted would be.
  Hello('b');
  Play(event::CommandReceived{Command('b', 1, AnchorOperation::kCreate, 1)});
  StoreRefuses(RoomAnchor{secret});
  const CommandReply refused = Only<effect::SendReply>().reply;
  EXPECT_EQ(refused.outcome, CommandOutcome::kNotFound);
  EXPECT_FALSE(refused.current);
}

TEST_F(Following, WhatBecomesPrivateGoesAndMayComeBack) {
  OpenWith("ab");
  Tell(1, 5);
  content::AnchorRecord record = Record(1, 6);
  record.visibility = content::AnchorVisibility::kPrivate;
  Tell(record);
  EXPECT_EQ(Only<effect::WithdrawAnchor>().anchor, AnchorNamed(1));
  EXPECT_EQ(Only<effect::PublishRoomState>().state.anchor_count, 0u);
  Play(event::CommandReceived{Command('b', 1, AnchorOperation::kMove, 1, 5)});
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kNotFound);
  record.visibility = content::AnchorVisibility::kPublic;
  record.revision = 7;
  Tell(record);
  EXPECT_EQ(Only<effect::PublishAnchor>().state.anchor.record.revision, 7u);
}

TEST_F(Following, ARetryThatFindsItsAnchorPrivateDoesNotShowIt) {
  OpenWith("ab");
  Play(event::CommandReceived{Command('a', 1, AnchorOperation::kCreate, 1)});
  const auto create = Only<effect::WriteAnchor>();
  RoomAnchor present{.record = create.record};
  present.record.revision = 6;
  present.record.visibility = content::AnchorVisibility::kPrivate;
  Play(event::WriteFinished{create.write, event::WriteFinished::Applied{present}});
  EXPECT_TRUE(None<effect::PublishAnchor>());
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kApplied);
}

TEST_F(Following, WhatItsOwnerAloneMayEditOthersOnlySee) {
  OpenWith("ab");
  content::AnchorRecord record = Record(1, 5);
  record.editing = content::AnchorEditing::kOwner;
  Tell(record);
  EXPECT_FALSE(None<effect::PublishAnchor>());
  Play(event::CommandReceived{Command('b', 1, AnchorOperation::kMove, 1, 5)});
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kInvalid);
  Play(event::CommandReceived{Command('a', 2, AnchorOperation::kMove, 1, 5)});
  EXPECT_FALSE(None<effect::WriteAnchor>());
}

}  // namespace
}  // namespace waymark::session
