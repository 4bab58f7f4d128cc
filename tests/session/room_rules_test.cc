// SPDX-License-Identifier: Apache-2.0
// What moderators decided outlives rooms and servers: the rules, and the file that keeps them.
#include <filesystem>

#include "mapping/base/file.h"
#include "session/server/rules_book.h"
#include "tests/session/rights_fixture.h"
#include "tests/support/temporary_root.h"

namespace waymark::session {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using testing::HasSubstr;

// ---- the rules --------------------------------------------------------------------------------

class Rules : public support::RightsScript {
 protected:
  /// The rules of a server that begins now with what another one had kept.
  void Restart(const RoomRules& kept) {
    state_ = SessionState(options_, RunId{43}, map_);
    Play(event::RulesFound{kept});
    EXPECT_TRUE(effects_.empty());
  }
  CommandReply Reply() const { return Only<effect::SendReply>().reply; }
};

// M  kick A . . . . . . . . kick V . . . . . .
//    A is gone, keep 1      V is gone   kept 1: answer, keep 2   kept 2: answer
TEST_F(Rules, HoldAtOnceAndAreAnsweredWhenTheyAreKept) {
  OpenWithRoles();
  SayOnly('M', 1, RoomOperation::kRemoveDevice, 'A');
  const auto first = Only<effect::KeepRules>();
  EXPECT_EQ(first.rules.bans.size(), 1u);
  EXPECT_EQ(Only<effect::WithdrawPresence>().device, Device('A'));
  EXPECT_TRUE(None<effect::SendReply>());
  SayOnly('M', 1, RoomOperation::kRemoveDevice, 'A');
  EXPECT_TRUE(effects_.empty()) << "a repetition waits as well";
  SayOnly('M', 2, RoomOperation::kRemoveDevice, 'V');
  EXPECT_EQ(Only<effect::WithdrawPresence>().device, Device('V'));
  EXPECT_TRUE(None<effect::KeepRules>()) << "one at a time";
  Play(event::RulesKept{first.version});
  EXPECT_EQ(Reply().request, Request(1));
  EXPECT_EQ(Reply().outcome, CommandOutcome::kApplied);
  const auto second = Only<effect::KeepRules>();
  EXPECT_EQ(second.rules.bans.size(), 2u);
  Play(event::RulesKept{first.version});
  EXPECT_TRUE(effects_.empty()) << "that was known";
  Play(event::RulesKept{second.version});
  EXPECT_EQ(Reply().request, Request(2));
  EXPECT_TRUE(None<effect::KeepRules>());
}

TEST_F(Rules, ThatCannotBeKeptAreSaidToBeSoAndTriedAgain) {
  OpenWithRoles();
  SayOnly('M', 1, RoomOperation::kRemoveDevice, 'A');
  Play(event::RulesKept{Only<effect::KeepRules>().version, "disk full"});
  EXPECT_EQ(Reply().outcome, CommandOutcome::kUnavailable);
  EXPECT_THAT(Reply().reason, HasSubstr("disk full"));
  HelloAs('A', Role::kMember);
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused) << "it holds nevertheless";
  Say('M', 1, RoomOperation::kRemoveDevice, 'A');  // the device repeats what was unavailable
  EXPECT_EQ(Reply().outcome, CommandOutcome::kApplied);
  EXPECT_EQ(Only<effect::KeepRules>().rules.bans.size(), 1u);
}

TEST_F(Rules, TheRemovedOneStaysOutOfTheNextServer) {
  OpenWithRoles();
  HelloAs('B', event::Permit{.token_id = "t"});
  Say('M', 1, RoomOperation::kRemoveDevice, 'B');
  const RoomRules kept = Only<effect::KeepRules>().rules;
  Wait(minutes(4));
  Restart(kept);
  OpenWithRoles();
  HelloAs('B', event::Permit{.token_id = "u"});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
  EXPECT_THAT(Answer().reason, HasSubstr("spam; may come back in 360 s"));
  HelloAs('C', event::Permit{.token_id = "t"});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused) << "nor its token";
  Wait(minutes(6));
  HelloAs('M', Role::kModerator);
  HelloAs('B', event::Permit{.token_id = "t"});
  EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted);
}

TEST_F(Rules, AClockThatWasSetBackKeepsNobodyOutForLonger) {
  Restart({.bans = {{{RoomId("square"), Device('A')}, {now_ + hours(5), "", ""}},
                    {{RoomId("square"), Device('B')}, {now_ - seconds(1), "", ""}}}});
  HelloAs('A', Role::kMember);
  EXPECT_THAT(Answer().reason, HasSubstr("600 s"));
  HelloAs('B', Role::kMember);
  EXPECT_FALSE(None<effect::LoadRoom>());
}

TEST_F(Rules, ACapacityIsTheRoomsWhoeverIsInIt) {
  OpenWithRoles();
  Say('M', 1, RoomOperation::kSetCapacity, 'A', 1);
  const RoomRules kept = Only<effect::KeepRules>().rules;
  for (const char letter : {'A', 'M', 'V'}) Play(event::DeviceLeft{Device(letter)});
  Wait(minutes(2));
  Play(event::Ticked{});
  ASSERT_EQ(state_.RoomCount(), 0u);
  for (const bool is_restarted : {false, true}) {
    if (is_restarted) Restart(kept);
    HelloAs('A', Role::kMember);
    LoadRoom();
    EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted);
    HelloAs('B', Role::kMember);
    EXPECT_THAT(Answer().reason, HasSubstr("holds its 1 devices")) << is_restarted;
  }
  Restart({.capacities = {{RoomId("square"), 5000}}});
  HelloAs('A', Role::kMember);
  LoadRoom();
  EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted) << "never more than the server's";
}

TEST_F(Rules, AreNotMoreThanTheServerCanHold) {
  options_.max_rules = 2;
  state_ = SessionState(options_, RunId{42}, map_);
  OpenWithRoles();
  HelloAs('B', Role::kMember);
  int request = 0;
  for (const char letter : {'A', 'V', 'B'}) {
    Say('M', ++request, RoomOperation::kRemoveDevice, letter);
    EXPECT_EQ(Reply().outcome, CommandOutcome::kApplied);
    Wait(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(state_.MemberCount(), 1u);
  HelloAs('V', Role::kMember);
  EXPECT_EQ(Answer().verdict, JoinVerdict::kRefused);
  HelloAs('A', Role::kMember);
  EXPECT_EQ(Answer().verdict, JoinVerdict::kAccepted) << "the first makes way for the third";
}

// ---- the file ---------------------------------------------------------------------------------

class Book : public Rules {
 protected:
  Book() { std::filesystem::create_directories(folder_); }
  ~Book() override { std::filesystem::remove_all(folder_); }

  const std::filesystem::path folder_ =
      waymark::support::TemporaryRoot() / ("waymark_rules_" + std::to_string(::getpid()));
  const RoomRules rules_{
      .capacities = {{RoomId("garden"), 7}, {RoomId("square"), 12}},
      .bans = {{{RoomId("square"), Device('A')}, {now_ + seconds(5), "t-1", "sells\nshoes  "}},
               {{RoomId("square"), Device('B')}, {now_ + minutes(5), "", ""}}}};
};

TEST_F(Book, IsReadAsItWasWritten) {
  const nanoseconds at_writing = hours(400'000), at_reading = at_writing - seconds(60);
  const auto read = ParseRules(FormatRules(rules_, at_writing), at_reading);
  ASSERT_TRUE(read.ok()) << ToString(read.error());
  EXPECT_EQ(read->capacities, rules_.capacities);
  ASSERT_EQ(read->bans.size(), 2u);
  const Ban& ban = read->bans.at({RoomId("square"), Device('A')});
  EXPECT_EQ(ban.until, now_ + seconds(65)) << "the next session's clock began a minute later";
  EXPECT_EQ(ban.token_id, "t-1");
  EXPECT_EQ(ban.reason, "sells shoes  ");
  EXPECT_EQ(read->bans.at({RoomId("square"), Device('B')}).token_id, "");
}

TEST_F(Book, OutlivesWhoWroteIt) {
  const RulesBook book(folder_ / "rules");
  EXPECT_TRUE(book.Load()->bans.empty());
  ASSERT_TRUE(book.Store(rules_).ok());
  EXPECT_EQ(RulesBook(folder_ / "rules").Load()->bans.size(), 2u);
  ASSERT_TRUE(book.Store({}).ok());
  EXPECT_TRUE(book.Load()->bans.empty());
  EXPECT_TRUE(RulesBook("").Store(rules_).ok());
  EXPECT_TRUE(RulesBook("").Load()->bans.empty());
  EXPECT_FALSE(RulesBook(folder_ / "no" / "rules").Store(rules_).ok());
}

TEST_F(Book, ADamagedLineIsNamed) {
  const std::string device = Device('A').text();
  for (const std::string& line :
       {std::string("capacity square many"), std::string("capacity square"),
        std::string("nonsense"), std::string("capacity square 99999999999"), "ban square " + device,
        "ban square " + device + " 12 ", "ban square " + device + " -5 t",
        "ban square " + device + " 9000000000000000000 t", std::string("ban square A 12 t")}) {
    const auto read = ParseRules("# a comment\n\n" + line + "\n", {});
    ASSERT_FALSE(read.ok()) << line;
    EXPECT_EQ(read.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(read.error().message, HasSubstr("line 3"));
  }
  ASSERT_TRUE(StoreFileAtomically(folder_ / "rules", std::string_view("nonsense")).ok());
  EXPECT_THAT(RulesBook(folder_ / "rules").Load().error().message,
              HasSubstr((folder_ / "rules").string()));
}

}  // namespace
}  // namespace waymark::session
