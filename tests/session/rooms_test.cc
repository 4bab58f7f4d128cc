// SPDX-License-Identifier: Apache-2.0
// Rooms with rights, over DDS or through a gateway: tokens, roles, and whom a moderator sends away.
#include "tests/session/session_fixture.h"

namespace waymark::session {
namespace {

using support::Eventually;
using support::FindAnchor;
using support::FindOther;
using support::kAhead;
using support::Sees;
using support::StandingPhone;
using testing::HasSubstr;

class Rooms : public support::SessionTest {
 protected:
  void SetUp() override {
    AskForTokens();
    StartServer();
  }
  DeviceOptions With(const std::string& name, const std::string& token) const {
    DeviceOptions options = MakeDeviceOptions(name);
    options.token = token;
    return options;
  }
  std::unique_ptr<DeviceSession> JoinAs(const std::string& name, Role role) const {
    return Join(With(name, IssueToken(role).token));
  }
};

TEST_F(Rooms, ATokenDecidesWhoComesAndAsWhat) {
  const auto refused = DeviceSession::Join(MakeDeviceOptions("Nobody"));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
  EXPECT_THAT(refused.error().message, HasSubstr("asks for one"));
  EXPECT_THAT(
      DeviceSession::Join(With("Lost", IssueToken(Role::kMember, "garden").token)).error().message,
      HasSubstr("room garden"));
  const auto anna = JoinAs("Anna", Role::kModerator), ben = JoinAs("Ben", Role::kViewer);
  ASSERT_TRUE(anna && ben);
  EXPECT_EQ(anna->Standing().role, Role::kModerator);
  EXPECT_TRUE(Eventually([&] { return Sees(*anna, ben->id()); }));
  EXPECT_EQ(FindOther(*anna, ben->id())->role, Role::kViewer);
}

TEST_F(Rooms, AViewerSeesAndWritesNothing) {
  const auto anna = JoinAs("Anna", Role::kMember), ben = JoinAs("Ben", Role::kViewer);
  StandingPhone anna_phone(*anna, {3, 4, 1}), ben_phone(*ben, {5, 4, 1});
  ASSERT_TRUE(anna_phone.Localise());
  ASSERT_TRUE(ben_phone.Localise()) << "it must know where it is to see";
  const auto anchor = anna->PlaceAnchor(kAhead, "note", "seen");
  ASSERT_TRUE(anchor.ok());
  EXPECT_TRUE(Eventually([&] { return FindAnchor(*ben, anchor->id).has_value(); }));
  EXPECT_TRUE(Eventually([&] {
    anna_phone.Live();
    ben_phone.Live();
    const auto other = FindOther(*ben, anna->id());
    return other && other->map_from_device;
  }));
  EXPECT_FALSE(FindOther(*anna, ben->id())->map_from_device);
  const auto refused = ben->PlaceAnchor(kAhead, "note", "not");
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message, HasSubstr("viewer"));
  EXPECT_FALSE(ben->MoveAnchor(*anchor, anchor->map_from_anchor).ok());
  EXPECT_FALSE(ben->DeleteAnchor(*anchor).ok());
  EXPECT_FALSE(ben->Kick(anna->id(), "").ok());
}

TEST_F(Rooms, AModeratorSendsSomebodyAway) {
  const auto anna = JoinAs("Anna", Role::kModerator), ben = JoinAs("Ben", Role::kMember);
  const std::string token = IssueToken(Role::kMember).token;
  const auto carl = Join(With("Carl", token));
  ASSERT_TRUE(Eventually([&] { return Sees(*ben, carl->id()); }));
  EXPECT_FALSE(ben->Kick(carl->id(), "no").ok());
  ASSERT_TRUE(anna->Kick(carl->id(), "sells shoes").ok());
  EXPECT_TRUE(Eventually([&] { return !carl->Standing().is_in; }));
  EXPECT_THAT(carl->Standing().reason, HasSubstr("sells shoes"));
  EXPECT_TRUE(Eventually([&] { return !Sees(*ben, carl->id()); }));
  StandingPhone phone(*carl, {3, 4, 1});
  const auto placed = carl->PlaceAnchor(kAhead, "note", "");
  ASSERT_FALSE(placed.ok());
  DeviceOptions again = With("Carl", token);
  again.id = carl->id();
  const auto returned = DeviceSession::Join(again);
  ASSERT_FALSE(returned.ok());
  EXPECT_THAT(returned.error().message, HasSubstr("may come back in"));
  again.id.reset();
  EXPECT_FALSE(DeviceSession::Join(again).ok()) << "under another name neither";
  ASSERT_TRUE(anna->Readmit(carl->id()).ok());
  EXPECT_TRUE(DeviceSession::Join(again).ok());
}

TEST_F(Rooms, AModeratorSetsHowManyMayCome) {
  const auto anna = JoinAs("Anna", Role::kModerator);
  EXPECT_FALSE(anna->SetCapacity(0).ok());
  ASSERT_TRUE(anna->SetCapacity(1).ok());
  const auto refused = DeviceSession::Join(With("Ben", IssueToken(Role::kMember).token));
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message, HasSubstr("holds its 1 devices"));
  ASSERT_TRUE(anna->SetCapacity(2).ok());
  EXPECT_TRUE(DeviceSession::Join(With("Ben", IssueToken(Role::kMember).token)).ok());
}

TEST_F(Rooms, WhoseTokenIsRevokedIsSentAway) {
  const auto anna = JoinAs("Anna", Role::kMember);
  const auto issued = IssueToken(Role::kMember);
  const auto ben = Join(With("Ben", issued.token));
  ASSERT_TRUE(Eventually([&] { return Sees(*anna, ben->id()); }));
  ASSERT_TRUE(authority_->Revoke("token", issued.id).ok());
  EXPECT_TRUE(Eventually([&] { return !ben->Standing().is_in; }));
  EXPECT_THAT(ben->Standing().reason, HasSubstr("revoked"));
  EXPECT_TRUE(Eventually([&] { return !Sees(*anna, ben->id()); }));
  EXPECT_TRUE(anna->Standing().is_in);
  EXPECT_FALSE(DeviceSession::Join(With("Ben", issued.token)).ok());
}

TEST_F(Rooms, TheNameOfSomebodyWhoIsHereOpensNothing) {
  const auto anna = JoinAs("Anna", Role::kMember), ben = JoinAs("Ben", Role::kMember);
  DeviceOptions impostor = With("Anna", IssueToken(Role::kModerator).token);
  impostor.id = anna->id();
  const auto session = DeviceSession::Join(impostor);
  ASSERT_FALSE(session.ok());
  EXPECT_THAT(session.error().message, HasSubstr("another token"));
  StandingPhone phone(*anna, {3, 4, 1});
  EXPECT_TRUE(phone.Localise()) << "she does not notice";
  EXPECT_TRUE(anna->PlaceAnchor(kAhead, "note", "mine").ok());
}

}  // namespace
}  // namespace waymark::session
