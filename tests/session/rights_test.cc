// SPDX-License-Identifier: Apache-2.0
// Who may come, as what, and who may send whom away.
#include "tests/session/rights_fixture.h"

namespace waymark::session {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;
using testing::HasSubstr;
using testing::SizeIs;

class Rights : public support::RightsScript {};

// ---- roles ------------------------------------------------------------------------------------

TEST_F(Rights, TheRoleIsToldToTheDeviceAndToTheRoom) {
  OpenWithRoles();
  EXPECT_EQ(Answer().role, Role::kViewer);
  EXPECT_EQ(Only<effect::PublishPresence>().presence.role, Role::kViewer);
}

TEST_F(Rights, AViewerSharesNoPoseAndWritesNoAnchor) {
  OpenWithRoles();
  Pose('V', 1);
  Pose('A', 2);
  Play(event::Ticked{});
  const auto shared = Only<effect::PublishPoses>().poses;
  ASSERT_THAT(shared, SizeIs(1));
  EXPECT_EQ(shared[0].number, state_.FindMember(TicketOf('A'))->number);
  Play(event::CommandReceived{Command('V', 1, AnchorOperation::kCreate, 1)});
  EXPECT_TRUE(None<effect::WriteAnchor>());
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kForbidden);
  EXPECT_THAT(Only<effect::SendReply>().reply.reason, HasSubstr("viewer"));
}

TEST_F(Rights, AModeratorEditsWhatIsOthersAlone) {
  options_.rights = AnchorRights::kOwner;
  state_ = SessionState(options_, RunId{42}, map_);
  OpenWithRoles();
  HelloAs('B', Role::kMember);
  Play(event::CommandReceived{Command('A', 1, AnchorOperation::kCreate, 1)});
  StoreApplies(1);
  Play(event::CommandReceived{Command('B', 2, AnchorOperation::kMove, 1, 1, 5)});
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kInvalid);
  Play(event::CommandReceived{Command('M', 3, AnchorOperation::kMove, 1, 1, 5)});
  EXPECT_EQ(Only<effect::WriteAnchor>().record.owner, Device('A').text()) << "it stays A's";
}

TEST_F(Rights, ANewTokenMayChangeTheRole) {
  OpenWithRoles();
  HelloAs('A', Role::kViewer);
  EXPECT_EQ(Answer().role, Role::kViewer);
  EXPECT_EQ(Only<effect::PublishPresence>().presence.role, Role::kViewer);
  HelloAs('A', Role::kViewer);
  EXPECT_TRUE(None<effect::PublishPresence>()) << "a repetition is no news";
}

// ---- tokens -----------------------------------------------------------------------------------

TEST_F(Rights, WhoIsRefusedByItsTokenOpensNothing) {
  HelloAs('A', event::Permit{.refusal = "token: has expired"});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
  EXPECT_THAT(Answer().reason, HasSubstr("expired"));
  EXPECT_TRUE(None<effect::LoadRoom>());
  EXPECT_EQ(state_.RoomCount(), 0u);
}

TEST_F(Rights, AnImpostorDoesNotEndTheDevice) {
  OpenWithRoles();
  HelloAs('A', event::Permit{.refusal = "token: is another device's"});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
  EXPECT_TRUE(None<effect::CloseDevice>());
  HelloAs('A', event::Permit{.refusal = "token: is for another room"}, "garden");
  EXPECT_TRUE(effects_.empty()) << "what is said to A stays where A is";
  EXPECT_NE(state_.FindMember(TicketOf('A')), nullptr);
}

TEST_F(Rights, ATokenForAnyDeviceDoesNotProveToBeOneThatIsHere) {
  OpenWithRoles();
  HelloAs('B', event::Permit{.token_id = "first"});
  HelloAs('B', event::Permit{.token_id = "second"});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
  EXPECT_THAT(Answer().reason, HasSubstr("another token"));
  HelloAs('B', event::Permit{.token_id = "third", .is_for_this_device = true});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted);
  // Nor one that is away.
  Play(event::DeviceLeft{Device('B'), false});
  HelloAs('B', event::Permit{.token_id = "second"});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
}

TEST_F(Rights, WhenATokenEndsItsDeviceGoes) {
  OpenWithRoles();
  HelloAs('B', event::Permit{.token_id = "t", .until = now_ + seconds(10)});
  Wait(seconds(9));
  for (const char letter : {'A', 'B', 'M', 'V'}) Play(event::Heard{TicketOf(letter)});
  Play(event::Ticked{});
  EXPECT_TRUE(None<effect::SendWelcome>());
  Wait(milliseconds(1001));
  Play(event::Ticked{});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRemoved);
  EXPECT_EQ(Only<effect::WithdrawPresence>().device, Device('B'));
}

TEST_F(Rights, WhatIsRevokedEndsAtOnce) {
  OpenWithRoles();
  HelloAs('B', event::Permit{.token_id = "b", .token_key = "k1"});
  HelloAs('C', event::Permit{.token_id = "c", .token_key = "k2"});
  Play(event::PermitsRevoked{{"b"}, {Device('A')}});
  EXPECT_THAT(All<effect::WithdrawPresence>(), SizeIs(2));
  EXPECT_EQ(All<effect::SendWelcome>()[0].welcome.verdict, JoinVerdict::kRemoved);
  Play(event::PermitsRevoked{{}, {}, {"k2"}});
  EXPECT_EQ(Only<effect::WithdrawPresence>().device, Device('C'));
}

// ---- moderators -------------------------------------------------------------------------------

TEST_F(Rights, OnlyAModeratorRemovesDevices) {
  OpenWithRoles();
  for (const char letter : {'A', 'V'}) {
    Say(letter, 1, RoomOperation::kRemoveDevice, 'M');
    EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kForbidden);
    EXPECT_TRUE(None<effect::WithdrawPresence>());
  }
}

// M  . . kick A . . . . . . . . . . readmit B
// A  hello . gone  hello: no . . . . 10 min: hello
TEST_F(Rights, TheRemovedOneIsGoneAtOnceLearnsWhyAndMayNotComeStraightBack) {
  OpenWithRoles();
  Say('M', 1, RoomOperation::kRemoveDevice, 'A');
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRemoved);
  EXPECT_EQ(Answer().device, Device('A'));
  EXPECT_THAT(Answer().reason, HasSubstr("spam"));
  EXPECT_EQ(Only<effect::WithdrawPresence>().device, Device('A'));
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kApplied);
  EXPECT_EQ(state_.FindMember(TicketOf('A')), nullptr);
  Say('M', 1, RoomOperation::kRemoveDevice, 'A');
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kApplied) << "a repetition";
  HelloAs('A', Role::kMember);
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
  EXPECT_THAT(Answer().reason, HasSubstr("600 s"));
  HelloAs('A', event::Permit{}, "garden");
  EXPECT_FALSE(None<effect::LoadRoom>()) << "other rooms do not mind";
  Wait(minutes(10));
  HelloAs('A', Role::kMember);
  EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted);
}

TEST_F(Rights, AnotherNameDoesNotHelpTheRemovedOnesToken) {
  OpenWithRoles();
  HelloAs('B', event::Permit{.token_id = "t"});
  Say('M', 1, RoomOperation::kRemoveDevice, 'B');
  HelloAs('C', event::Permit{.token_id = "t"});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
  HelloAs('C', event::Permit{.token_id = "u"});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted);
  Say('M', 2, RoomOperation::kReadmitDevice, 'B');
  HelloAs('B', event::Permit{.token_id = "t"});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted);
  Say('M', 3, RoomOperation::kReadmitDevice, 'B');
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kNotFound);
}

TEST_F(Rights, AModeratorRemovesNeitherItselfNorWhoIsElsewhere) {
  OpenWithRoles();
  HelloAs('B', event::Permit{}, "garden");
  LoadRoom("garden");
  Say('M', 1, RoomOperation::kRemoveDevice, 'B');
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kNotFound);
  Say('M', 2, RoomOperation::kRemoveDevice, 'M');
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kInvalid);
}

TEST_F(Rights, AModeratorSetsTheCapacity) {
  OpenWithRoles();
  Say('M', 1, RoomOperation::kSetCapacity, 'A', 3);
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kApplied);
  HelloAs('B', Role::kMember);
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
  EXPECT_THAT(Answer().reason, HasSubstr("3 devices"));
  for (const std::uint32_t capacity : {0u, 1025u}) {
    Say('M', static_cast<int>(2 + capacity), RoomOperation::kSetCapacity, 'A', capacity);
    EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kInvalid);
  }
}

TEST_F(Rights, ARoomMayWaitForItsModerator) {
  options_.opening = RoomOpening::kModerators;
  state_ = SessionState(options_, RunId{42}, map_);
  HelloAs('A', Role::kMember);
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
  HelloAs('M', Role::kModerator);
  LoadRoom();
  HelloAs('A', Role::kMember);
  EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted);
}

}  // namespace
}  // namespace waymark::session
