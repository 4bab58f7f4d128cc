// SPDX-License-Identifier: Apache-2.0
// Tokens: what is let in, and all that is not.
#include <fstream>

#include "session/keys/authority.h"
#include "session/keys/token_door.h"
#include "tests/support/temporary_root.h"

#include <gmock/gmock.h>
#include <unistd.h>

namespace waymark::session::keys {
namespace {

using std::chrono::hours;
using std::chrono::seconds;
using testing::HasSubstr;
using testing::IsEmpty;

const DeviceId kDevice("01234567-89ab-4def-bedc-ba9876543210");
constexpr WallTime kNow(std::chrono::seconds(1'700'000'000));
const ServerTime kServerNow(hours(5));

class Tokens : public testing::Test {
 protected:
  Tokens()
      : folder_(waymark::support::TemporaryRoot() /
                ("waymark_tokens_" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(folder_);
    auto made = Authority::Create(folder_);
    EXPECT_TRUE(made.ok()) << ToString(made.error());
    authority_.emplace(*std::move(made));
    OpenDoor();
  }
  ~Tokens() override { std::filesystem::remove_all(folder_); }

  void OpenDoor() {
    auto door = TokenDoor::Open({.folder = folder_});
    ASSERT_TRUE(door.ok()) << ToString(door.error());
    door_ = *std::move(door);
  }
  static TokenClaims Claims() {
    return {.room = RoomId("square"),
            .role = Role::kModerator,
            .issued = kNow,
            .expires = kNow + hours(1)};
  }
  std::string Issue(const TokenClaims& claims = Claims()) {
    const auto issued = authority_->IssueToken(claims);
    EXPECT_TRUE(issued.ok()) << ToString(issued.error());
    last_id_ = issued.ok() ? issued->id : "";
    return issued.ok() ? issued->token : "";
  }
  event::Permit Show(const std::string& token, WallTime now = kNow,
                     const std::string& room = "square") {
    return door_->Check({.device = kDevice, .room = RoomId(room), .name = "", .token = token}, now,
                        kServerNow);
  }

  std::filesystem::path folder_;
  std::optional<Authority> authority_;
  std::unique_ptr<TokenDoor> door_;
  std::string last_id_;
};

TEST_F(Tokens, AGenuineOneGrantsWhatItSays) {
  const event::Permit permit = Show(Issue());
  EXPECT_THAT(permit.refusal, IsEmpty());
  EXPECT_EQ(permit.role, Role::kModerator);
  EXPECT_EQ(permit.token_id, last_id_);
  EXPECT_FALSE(permit.is_for_this_device);
  EXPECT_EQ(permit.until, kServerNow + hours(1) + seconds(60)) << "with the skew";
}

TEST_F(Tokens, NoneIsRefusedWithTheWayToOne) {
  EXPECT_THAT(Show("").refusal, HasSubstr("waymark-keys token"));
}

TEST_F(Tokens, EveryChangedCharacterIsNoticed) {
  const std::string token = Issue();
  ASSERT_LE(token.size(), 512u);
  for (std::size_t i = 0; i < token.size(); ++i) {
    std::string changed = token;
    changed[i] = changed[i] == 'A' ? 'B' : 'A';
    EXPECT_THAT(Show(changed).refusal, testing::Not(IsEmpty())) << "at " << i;
    EXPECT_THAT(Show(token.substr(0, i)).refusal, testing::Not(IsEmpty())) << "cut at " << i;
  }
}

TEST_F(Tokens, AnothersKeyDoesNotCount) {
  const auto stranger = TokenSigningKey::Generate();
  TokenClaims claims = Claims();
  claims.id = "x";
  EXPECT_THAT(Show(*IssueToken(claims, *stranger)).refusal, HasSubstr("key is not known"));
  // Not even when it says to be ours: the claims of one under the signature of the other.
  const std::string ours = Issue(), theirs = *IssueToken(claims, *stranger);
  const std::string forged = ours.substr(0, ours.rfind('.')) + theirs.substr(theirs.rfind('.'));
  EXPECT_THAT(Show(forged).refusal, HasSubstr("not genuine"));
}

TEST_F(Tokens, TimesCountWithTheSkewOfClocks) {
  const std::string token = Issue();
  EXPECT_THAT(Show(token, kNow + hours(1) + seconds(59)).refusal, IsEmpty());
  EXPECT_THAT(Show(token, kNow + hours(1) + seconds(60)).refusal, HasSubstr("expired"));
  EXPECT_THAT(Show(token, kNow - seconds(60)).refusal, IsEmpty());
  EXPECT_THAT(Show(token, kNow - seconds(61)).refusal, HasSubstr("not valid yet"));
}

TEST_F(Tokens, ItIsGoodForItsRoomAndDeviceAlone) {
  EXPECT_THAT(Show(Issue(), kNow, "garden").refusal, HasSubstr("room square"));
  TokenClaims claims = Claims();
  claims.device = kDevice;
  EXPECT_TRUE(Show(Issue(claims)).is_for_this_device);
  claims.device = DeviceId("11234567-89ab-4def-bedc-ba9876543210");
  EXPECT_THAT(Show(Issue(claims)).refusal, HasSubstr("another device"));
}

TEST_F(Tokens, WhatIsRevokedIsReadAgain) {
  const std::string token = Issue();
  const std::string id = last_id_;
  EXPECT_FALSE(door_->Refresh().has_value());
  ASSERT_TRUE(authority_->Revoke("token", id).ok());
  const auto revoked = door_->Refresh();
  ASSERT_TRUE(revoked.has_value());
  EXPECT_THAT(revoked->token_ids, testing::ElementsAre(id));
  EXPECT_THAT(Show(token).refusal, HasSubstr("revoked"));
  EXPECT_THAT(Show(Issue()).refusal, IsEmpty());
  ASSERT_TRUE(authority_->Revoke("device", kDevice.text()).ok());
  EXPECT_TRUE(door_->Refresh().has_value());
  EXPECT_THAT(Show(Issue()).refusal, HasSubstr("revoked"));
}

TEST_F(Tokens, AKeyMayBeChangedAndItsTokensEnded) {
  const std::string before = Issue();
  const std::string key = ParseToken(before)->claims.key;
  ASSERT_TRUE(authority_->ChangeTokenKey().ok());
  EXPECT_TRUE(door_->Refresh().has_value());
  EXPECT_THAT(Show(before).refusal, IsEmpty()) << "earlier ones stay good";
  EXPECT_THAT(Show(Issue()).refusal, IsEmpty());
  ASSERT_TRUE(authority_->Revoke("key", key).ok());
  EXPECT_TRUE(door_->Refresh().has_value());
  EXPECT_THAT(Show(before).refusal, HasSubstr("revoked"));
  EXPECT_THAT(Show(Issue()).refusal, IsEmpty());
}

TEST_F(Tokens, AListThatIsNotUnderstoodLeavesTheOneBeforeInForce) {
  const std::string token = Issue();
  ASSERT_TRUE(authority_->Revoke("token", last_id_).ok());
  EXPECT_TRUE(door_->Refresh().has_value());
  std::ofstream(folder_ / kRevocationsFile) << "tokn oops\n";
  EXPECT_FALSE(door_->Refresh().has_value());
  EXPECT_THAT(Show(token).refusal, HasSubstr("revoked"));
  const auto opened = TokenDoor::Open({.folder = folder_});
  ASSERT_FALSE(opened.ok()) << "a server does not start on it";
  EXPECT_THAT(opened.error().message, HasSubstr("line 1"));
}

TEST_F(Tokens, SecretsAreTheOwnersAlone) {
  const auto status = std::filesystem::status(folder_ / "secret");
  EXPECT_EQ(status.permissions(), std::filesystem::perms::owner_all);
  EXPECT_EQ(Authority::Create(folder_).error().code, ErrorCode::kConflict) << "never overwritten";
  EXPECT_EQ(Authority::Open(folder_ / "nothing").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(TokenDoor::Open({.folder = folder_ / "nothing"}).error().code, ErrorCode::kNotFound);
}

TEST_F(Tokens, WhatCannotBeGrantedIsNamed) {
  TokenClaims claims = Claims();
  claims.room = RoomId("no such.room");
  EXPECT_THAT(authority_->IssueToken(claims).error().message, HasSubstr("no such.room"));
  claims = Claims();
  claims.device = DeviceId("phone");
  EXPECT_THAT(authority_->IssueToken(claims).error().message, HasSubstr("UUID"));
  claims = Claims();
  claims.expires = claims.issued;
  EXPECT_FALSE(authority_->IssueToken(claims).ok());
}

}  // namespace
}  // namespace waymark::session::keys
