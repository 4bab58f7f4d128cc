// SPDX-License-Identifier: Apache-2.0
// Who guesses must wait.
#include "session/gateway/join_gate.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include "session/keys/authority.h"
#include "tests/support/temporary_root.h"

namespace waymark::session::internal {
namespace {

using std::chrono::seconds;
using testing::HasSubstr;

const DeviceId kDevice("01234567-89ab-4def-bedc-ba9876543210");
constexpr keys::WallTime kWall(seconds(1'700'000'000));

class JoinGateTest : public testing::Test {
 protected:
  JoinGateTest()
      : folder_(waymark::support::TemporaryRoot() /
                ("waymark_gate_" + std::to_string(::getpid()))) {
    std::filesystem::remove_all(folder_);
    const auto authority = keys::Authority::Create(folder_);
    EXPECT_TRUE(authority.ok());
    token_ = authority
                 ->IssueToken(
                     {.room = RoomId("square"), .issued = kWall, .expires = kWall + seconds(3600)})
                 ->token;
    auto door = keys::TokenDoor::Open({.folder = folder_});
    EXPECT_TRUE(door.ok());
    gate_.emplace(std::shared_ptr<keys::TokenDoor>(*std::move(door)));
  }
  ~JoinGateTest() override { std::filesystem::remove_all(folder_); }

  std::optional<std::string> Come(const std::string& token, const std::string& peer) {
    return gate_->FindObjection(
        {.device = kDevice, .room = RoomId("square"), .name = "", .token = token}, peer, kWall,
        now_);
  }

  std::filesystem::path folder_;
  std::string token_;
  std::optional<JoinGate> gate_;
  JoinGate::Instant now_ = JoinGate::Instant() + std::chrono::hours(1);
};

TEST_F(JoinGateTest, GuessesAreSlowedByAddress) {
  EXPECT_FALSE(Come(token_, "10.0.0.1:1"));
  for (int i = 0; i < 10; ++i) {
    EXPECT_THAT(Come("v1.e30.e30", "10.0.0.1:" + std::to_string(i)).value_or(""),
                HasSubstr("token"));
  }
  EXPECT_THAT(Come("v1.e30.e30", "10.0.0.1:99").value_or(""), HasSubstr("too many attempts"));
  EXPECT_THAT(Come(token_, "10.0.0.1:99").value_or(""), HasSubstr("too many attempts"))
      << "whether the next guess is right is not told either";
  EXPECT_FALSE(Come(token_, "10.0.0.2:1")) << "others do not notice";
  now_ += seconds(11);
  EXPECT_FALSE(Come(token_, "10.0.0.1:5"));
  EXPECT_THAT(Come("v1.e30.e30", "10.0.0.1:5").value_or(""), HasSubstr("token"));
  EXPECT_THAT(Come("v1.e30.e30", "10.0.0.1:5").value_or(""), HasSubstr("too many attempts"));
}

TEST_F(JoinGateTest, ACrowdBehindOneAddressMayCome) {
  for (int i = 0; i < 500; ++i) EXPECT_FALSE(Come(token_, "10.0.0.1:" + std::to_string(i)));
  EXPECT_TRUE(Come(token_, "10.0.0.1:7").has_value());
  now_ += seconds(1);
  for (int i = 0; i < 50; ++i) EXPECT_FALSE(Come(token_, "10.0.0.1:" + std::to_string(i)));
}

TEST_F(JoinGateTest, ItsMemoryIsBounded) {
  for (int i = 0; i < 20'000; ++i) {
    EXPECT_TRUE(Come("", fmt::format("10.{}.{}.{}:1", i / 65536, i / 256 % 256, i % 256)));
  }
  now_ += std::chrono::minutes(3);
  EXPECT_FALSE(Come(token_, "10.9.9.9:1"));
}

TEST_F(JoinGateTest, WithoutADoorEverybodyMayPass) {
  gate_.emplace(nullptr);
  EXPECT_FALSE(Come("", "10.0.0.1:1"));
}

}  // namespace
}  // namespace waymark::session::internal
