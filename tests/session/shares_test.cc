// SPDX-License-Identifier: Apache-2.0
// Each device on the bus has its share, whatever others say.
#include "session/wire/shares.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>

namespace waymark::session::wire {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr const char* kFlooder = "room.square.up.01234567-89ab-4def-bedc-ba9876543210";
constexpr const char* kOther = "room.square.up.11234567-89ab-4def-bedc-ba9876543210";

class SharesTest : public testing::Test {
 protected:
  int Flood(const std::string& partition, int messages, std::size_t bytes = 0) {
    int heard = 0;
    for (int i = 0; i < messages; ++i) heard += shares_.Take(partition, bytes, now_);
    return heard;
  }

  Shares::Time now_ = std::chrono::steady_clock::now();
  Shares shares_{{.messages_per_s = 100, .bytes_per_s = 10'000}};
};

TEST_F(SharesTest, WhoFloodsLosesItsOwnMessagesAlone) {
  EXPECT_EQ(Flood(kFlooder, 5000), 200) << "two seconds' share at once";
  EXPECT_EQ(Flood(kOther, 200), 200);
  EXPECT_EQ(shares_.Throttled(), 4800u);
  now_ += milliseconds(500);
  EXPECT_EQ(Flood(kFlooder, 5000), 50);
  now_ += seconds(3600);
  EXPECT_EQ(Flood(kFlooder, 5000), 200);
}

TEST_F(SharesTest, LargeMessagesCountByTheirBytes) {
  EXPECT_EQ(Flood(kFlooder, 100, 4000), 5);
  EXPECT_EQ(Flood(kOther, 5, 4000), 5);
}

TEST_F(SharesTest, AGatewaySeesToItsPhonesItself) {
  EXPECT_EQ(Flood("room.square.up.gateway", 5000), 5000);
  EXPECT_EQ(shares_.Throttled(), 0u);
}

// Where nobody is authenticated one may write under any name; neither memory nor log grows.
TEST_F(SharesTest, AFloodOfNamesFillsNeitherMemoryNorLog) {
  testing::internal::CaptureStderr();
  for (int i = 0; i < 100'000; ++i) Flood(fmt::format("room.r.up.\n{}", i), i < 500 ? 300 : 1);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_LE(std::count(log.begin(), log.end(), '\n'), 40);
  EXPECT_THAT(log, testing::HasSubstr("somebody on the bus: says too much"));
}

TEST_F(SharesTest, TheLogNamesTheDeviceOnceAMinute) {
  testing::internal::CaptureStderr();
  for (int second = 0; second < 70; ++second) {
    Flood(kFlooder, 1000);
    now_ += seconds(1);
  }
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, testing::HasSubstr("device 01234567-89ab-4def-bedc-ba9876543210: says too"));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 2);
}

}  // namespace
}  // namespace waymark::session::wire
