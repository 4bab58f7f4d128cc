// SPDX-License-Identifier: Apache-2.0
#include <set>

#include "tests/session/state_fixture.h"

namespace waymark::session {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;
using testing::SizeIs;

using State = support::StateScript;

// ---- joining and leaving ----------------------------------------------------------------------

TEST_F(State, TheFirstHelloOpensTheRoomAndIsAnsweredWhenItIsRead) {
  Hello('A');
  EXPECT_EQ(Only<effect::LoadRoom>().room, RoomId("square"));
  EXPECT_TRUE(None<effect::SendWelcome>());
  Hello('A');
  EXPECT_TRUE(effects_.empty()) << "a repetition asks for nothing more";
  LoadRoom();
  EXPECT_EQ(Only<effect::OpenRoom>().room, RoomId("square"));
  const Welcome welcome = Only<effect::SendWelcome>().welcome;
  EXPECT_EQ(welcome.device, Device('A'));
  EXPECT_EQ(welcome.verdict, JoinVerdict::kAccepted);
  EXPECT_EQ(welcome.attempt, 7u);
  EXPECT_EQ(welcome.ticket, TicketOf('A'));
  EXPECT_EQ(welcome.run, RunId{42});
  EXPECT_EQ(Only<effect::PublishPresence>().presence.name, "A");
  EXPECT_EQ(Only<effect::PublishRoomState>().state.anchor_count, 0u);
}

TEST_F(State, ARepeatedHelloGetsTheSameTicketAndIsNotNews) {
  OpenWith("A");
  Play(event::HelloReceived{
      {.device = Device('A'), .attempt = 8, .room = RoomId("square"), .name = "A"}, Ticket{5}});
  EXPECT_EQ(Only<effect::SendWelcome>().welcome.ticket, TicketOf('A'));
  EXPECT_EQ(Only<effect::SendWelcome>().welcome.attempt, 8u);
  EXPECT_TRUE(Only<effect::SendWelcome>().welcome.is_return) << "it began anew";
  EXPECT_TRUE(None<effect::PublishPresence>());
  EXPECT_EQ(state_.MemberCount(), 1u);
}

// A Hello is said until it is answered, and may be heard once more after that.
TEST_F(State, AHelloThatIsHeardTwiceIsAnsweredAlike) {
  OpenWith("AB");
  const Welcome first = Only<effect::SendWelcome>().welcome;
  EXPECT_FALSE(first.is_return);
  Hello('B');
  const Welcome second = Only<effect::SendWelcome>().welcome;
  EXPECT_FALSE(second.is_return);
  EXPECT_EQ(second.ticket, first.ticket);
}

TEST_F(State, NumbersAndTicketsNameOneDevice) {
  OpenWith("ABC");
  std::set<DeviceNumber> numbers;
  for (const char letter : {'A', 'B', 'C'}) {
    ASSERT_NE(state_.FindMember(TicketOf(letter)), nullptr);
    EXPECT_EQ(state_.FindMember(TicketOf(letter))->device, Device(letter));
    numbers.insert(state_.FindMember(TicketOf(letter))->number);
  }
  EXPECT_THAT(numbers, SizeIs(3));
  EXPECT_EQ(state_.FindMember(Ticket{1}), nullptr);
}

TEST_F(State, LeavingIsToldAtOnce) {
  OpenWith("AB");
  Play(event::DeviceLeft{Device('A')});
  EXPECT_EQ(Only<effect::WithdrawPresence>().device, Device('A'));
  EXPECT_EQ(Only<effect::CloseDevice>().device, Device('A'));
  EXPECT_EQ(state_.FindMember(TicketOf('A')), nullptr);
  Play(event::DeviceLeft{Device('A')});
  EXPECT_TRUE(effects_.empty());
}

// A  hello . . . . . . . . gone
// B  hello . beat . beat . .
TEST_F(State, SilenceIsAbsenceAfterTheTimeout) {
  OpenWith("AB");
  Wait(seconds(2));
  Play(event::Heard{TicketOf('B')});
  Wait(milliseconds(1001));
  Play(event::Ticked{});
  EXPECT_EQ(Only<effect::WithdrawPresence>().device, Device('A'));
  EXPECT_NE(state_.FindMember(TicketOf('B')), nullptr);
  Pose('A', 1);
  EXPECT_TRUE(effects_.empty()) << "its ticket means nothing any more";
  Hello('A');
  EXPECT_EQ(Only<effect::SendWelcome>().welcome.verdict, JoinVerdict::kAccepted);
}

TEST_F(State, ADeviceIsInOneRoom) {
  OpenWith("AB");
  Hello('A', "garden");
  EXPECT_EQ(Only<effect::WithdrawPresence>().room, RoomId("square"));
  LoadRoom("garden");
  EXPECT_EQ(Only<effect::SendWelcome>().room, RoomId("garden"));
  EXPECT_EQ(state_.MemberCount(), 2u);
}

TEST_F(State, LimitsAreRefusedWithAReason) {
  options_.max_rooms = 1;
  options_.max_members = 2;
  state_ = SessionState(options_, RunId{42}, map_);
  OpenWith("AB");
  Hello('C');
  EXPECT_EQ(Only<effect::SendWelcome>().welcome.verdict, JoinVerdict::kRefused);
  EXPECT_THAT(Only<effect::SendWelcome>().welcome.reason, HasSubstr("2 devices"));
  EXPECT_EQ(Only<effect::CloseDevice>().device, Device('C'));
  Hello('C', "garden");
  EXPECT_EQ(Only<effect::SendWelcome>().welcome.verdict, JoinVerdict::kRefused);
  Hello('C', "square", kOldestProtocol - 1);
  EXPECT_EQ(Only<effect::SendWelcome>().welcome.verdict, JoinVerdict::kInvalid);
  EXPECT_THAT(Only<effect::SendWelcome>().welcome.reason, HasSubstr("protocol"));
}

TEST_F(State, ARoomThatCannotBeReadTellsThoseWhoWait) {
  Hello('A');
  Hello('B');
  Play(event::RoomLoaded{RoomId("square"), MakeError(ErrorCode::kUnavailable, "disk"), {}});
  EXPECT_THAT(All<effect::SendWelcome>(), SizeIs(2));
  EXPECT_EQ(All<effect::SendWelcome>()[0].welcome.verdict, JoinVerdict::kUnavailable);
  EXPECT_EQ(state_.RoomCount(), 0u);
  Hello('A');
  EXPECT_FALSE(None<effect::LoadRoom>()) << "the next one tries again";
}

TEST_F(State, AnEmptyRoomClosesAfterAWhile) {
  OpenWith("A");
  Play(event::DeviceLeft{Device('A')});
  Wait(seconds(59));
  Play(event::Ticked{});
  EXPECT_TRUE(None<effect::CloseRoom>());
  Wait(seconds(2));
  Play(event::Ticked{});
  EXPECT_EQ(Only<effect::CloseRoom>().room, RoomId("square"));
  EXPECT_EQ(state_.RoomCount(), 0u);
}

// ---- poses ------------------------------------------------------------------------------------

TEST_F(State, NewPosesGoOutOnceAndAgainNowAndThen) {
  OpenWith("AB");
  Pose('A', 3);
  EXPECT_TRUE(effects_.empty()) << "only a tick sends";
  Play(event::Ticked{});
  const auto batch = Only<effect::PublishPoses>();
  ASSERT_THAT(batch.poses, SizeIs(1));
  EXPECT_EQ(batch.poses[0].pose.map_from_device.translation().x(), 3);
  EXPECT_EQ(batch.poses[0].number, state_.FindMember(TicketOf('A'))->number);
  Wait(milliseconds(33));
  Play(event::Ticked{});
  EXPECT_TRUE(None<effect::PublishPoses>());
  Wait(milliseconds(500));
  (void)TickUntilPosesAreTold();
  EXPECT_THAT(Only<effect::PublishPoses>().poses, SizeIs(1));
}

TEST_F(State, PosesWaitForTheFrameUnlessACrowdListens) {
  const auto ticks_until_told = [this] {
    Pose('A', 3);
    return TickUntilPosesAreTold();
  };
  OpenWith("AB");
  (void)ticks_until_told();
  EXPECT_EQ(ticks_until_told(), kTicksPerFrame);
  for (char letter = 1; letter < 64; ++letter) Hello(letter);
  (void)ticks_until_told();
  EXPECT_EQ(ticks_until_told(), 1u);
}

TEST_F(State, PosesOfAnotherEpochAnotherTimeOrOutOfOrderAreNotShared) {
  OpenWith("AB");
  Pose('A', 3, 2);
  Play(event::PoseReceived{
      {.ticket = TicketOf('A'),
       .pose = {.time = now_ + seconds(60), .map_from_device = {}, .sigma_m = 0}}});
  Play(event::PoseReceived{
      {.ticket = TicketOf('A'),
       .pose = {.time = now_ - seconds(60), .map_from_device = {}, .sigma_m = 0}}});
  Play(event::Ticked{});
  EXPECT_TRUE(None<effect::PublishPoses>());
  Pose('A', 3);
  Play(event::PoseReceived{
      {.ticket = TicketOf('A'),
       .pose = {.time = now_ - milliseconds(1), .map_from_device = {}, .sigma_m = 0}}});
  Play(event::Ticked{});
  EXPECT_EQ(Only<effect::PublishPoses>().poses[0].pose.map_from_device.translation().x(), 3);
}

TEST_F(State, TheSameEventsGiveTheSameEffects) {
  const auto play = [this] {
    state_ = SessionState(options_, RunId{42}, map_);
    now_ = ServerTime(std::chrono::hours(1));
    OpenWith("ABC");
    Pose('A', 3);
    Pose('C', 4);
    Play(event::Ticked{});
    return Only<effect::PublishPoses>();
  };
  const auto first = play(), second = play();
  ASSERT_EQ(first.poses.size(), second.poses.size());
  for (std::size_t i = 0; i < first.poses.size(); ++i) {
    EXPECT_EQ(first.poses[i].number, second.poses[i].number);
  }
}

}  // namespace
}  // namespace waymark::session
