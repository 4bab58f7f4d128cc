// SPDX-License-Identifier: Apache-2.0
// Who is away for a while, and who comes back as itself.
#include "tests/session/rights_fixture.h"

namespace waymark::session {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;
using testing::HasSubstr;
using testing::SizeIs;

class Absence : public support::RightsScript {};

// A  hello . . pause (gone after 3 s) . . . hello: itself
TEST_F(Absence, WhoPausesComesBackAsItself) {
  OpenWith("AB");
  const DeviceNumber number = state_.FindMember(TicketOf('A'))->number;
  Play(event::CommandReceived{Command('A', 1, AnchorOperation::kCreate, 1)});
  const auto wanted = Only<effect::WriteAnchor>();
  Wait(milliseconds(3001));
  Play(event::Heard{TicketOf('B')});
  Play(event::Ticked{});
  EXPECT_EQ(Only<effect::WithdrawPresence>().device, Device('A')) << "for the others it is gone";
  EXPECT_EQ(state_.AwayCount(), 1u);
  RoomAnchor written{.record = wanted.record};
  written.record.revision = 1;
  Play(event::WriteFinished{wanted.write, event::WriteFinished::Applied{written}});
  Wait(seconds(50));
  Play(event::HelloReceived{
      {.device = Device('A'), .attempt = 8, .room = RoomId("square"), .name = "A"}, Ticket{5}});
  EXPECT_TRUE(Answer().is_return);
  EXPECT_EQ(Answer().number, number);
  EXPECT_EQ(Answer().ticket, TicketOf('A'));
  EXPECT_EQ(Only<effect::PublishPresence>().presence.number, number);
  Play(event::CommandReceived{Command('A', 1, AnchorOperation::kCreate, 1)});
  EXPECT_TRUE(None<effect::WriteAnchor>()) << "what was done meanwhile is not done again";
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kApplied);
}

TEST_F(Absence, AfterAMinuteOrAGoodbyeItIsANewcomer) {
  OpenWith("ABC");
  Play(event::DeviceLeft{Device('A'), false});
  Play(event::DeviceLeft{Device('B'), true});
  EXPECT_EQ(state_.AwayCount(), 1u);
  Hello('B');
  EXPECT_FALSE(Answer().is_return);
  Wait(milliseconds(60'001));
  for (const char letter : {'B', 'C'}) Play(event::Heard{TicketOf(letter)});
  Play(event::Ticked{});
  EXPECT_EQ(state_.AwayCount(), 0u);
  Hello('A');
  EXPECT_FALSE(Answer().is_return);
}

TEST_F(Absence, TheSeatOfWhoIsAwayIsKept) {
  options_.max_members = 2;
  state_ = SessionState(options_, RunId{42}, map_);
  OpenWith("AB");
  Play(event::DeviceLeft{Device('A'), false});
  Hello('C');
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
  Hello('A');
  EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted);
  Play(event::DeviceLeft{Device('A'), false});
  Wait(milliseconds(60'001));
  Play(event::Heard{TicketOf('B')});
  Play(event::Ticked{});
  Hello('C');
  EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted) << "for a minute";
  Hello('A');
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
}

TEST_F(Absence, WhoIsRemovedWhileAwayMayNotReturn) {
  OpenWithRoles();
  Play(event::DeviceLeft{Device('A'), false});
  Say('M', 1, RoomOperation::kRemoveDevice, 'A');
  EXPECT_EQ(Only<effect::SendReply>().reply.outcome, CommandOutcome::kApplied);
  EXPECT_EQ(state_.AwayCount(), 0u);
  HelloAs('A', Role::kMember);
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
}

TEST_F(Absence, APoseOfBeforeIsNotShownAfterTheReturn) {
  OpenWith("AB");
  Pose('A', 3);
  Play(event::DeviceLeft{Device('A'), false});
  Hello('A');
  Play(event::Ticked{});
  EXPECT_TRUE(None<effect::PublishPoses>());
}

// The clock of the session may be stepped by an hour, either way: nobody is lost for ever.
TEST_F(Absence, AClockThatJumpsCostsAtMostAReturn) {
  for (const auto step : {std::chrono::hours(1), std::chrono::hours(-1)}) {
    state_ = SessionState(options_, RunId{42}, map_);
    now_ = ServerTime(std::chrono::hours(10));
    OpenWith("AB");
    for (const char letter : {'A', 'B'}) Pose(letter, 1);
    Wait(step);
    Play(event::Ticked{});
    for (const char letter : {'A', 'B'}) {
      Hello(letter);
      EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted);
      Pose(letter, 2);
    }
    (void)TickUntilPosesAreTold();
    EXPECT_THAT(Only<effect::PublishPoses>().poses, SizeIs(2));
    EXPECT_EQ(state_.MemberCount(), 2u);
    // Silence is noticed as ever.
    Wait(milliseconds(3001));
    Play(event::Ticked{});
    EXPECT_EQ(state_.MemberCount(), 0u);
  }
}

}  // namespace
}  // namespace waymark::session
