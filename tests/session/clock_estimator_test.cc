// SPDX-License-Identifier: Apache-2.0
#include "session/device/clock_estimator.h"

#include <gtest/gtest.h>

namespace waymark::session {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

ClockExchange Exchange(nanoseconds offset, nanoseconds up, nanoseconds down) {
  const DeviceTime sent{seconds(100)};
  const ServerTime received{sent.time_since_epoch() + offset + up};
  const ServerTime replied = received + milliseconds(1);
  return {sent, received, replied, DeviceTime{replied.time_since_epoch() - offset + down}};
}

TEST(ClockEstimator, TakesTheExchangeWithTheLeastDelay) {
  constexpr nanoseconds kOffset = seconds(-12345);
  ClockEstimator clock;
  EXPECT_FALSE(clock.ToSession(DeviceTime{}));
  clock.Add(Exchange(kOffset, milliseconds(90), milliseconds(10)));
  EXPECT_EQ(*clock.ToSession(DeviceTime{}), ServerTime{kOffset + milliseconds(40)});
  clock.Add(Exchange(kOffset, milliseconds(5), milliseconds(5)));
  clock.Add(Exchange(kOffset, milliseconds(5), milliseconds(500)));
  EXPECT_EQ(*clock.ToSession(DeviceTime{}), ServerTime{kOffset});
  EXPECT_EQ(*clock.Delay(), milliseconds(10));
}

TEST(ClockEstimator, ForgetsWhatIsOldAndIgnoresTheImpossible) {
  ClockEstimator clock;
  clock.Add(Exchange(seconds(1), milliseconds(1), milliseconds(1)));
  for (int i = 0; i < 32; ++i) clock.Add(Exchange(seconds(2), milliseconds(9), milliseconds(9)));
  EXPECT_EQ(*clock.ToSession(DeviceTime{}), ServerTime{seconds(2)}) << "clocks drift";
  clock.Add(Exchange(seconds(3), milliseconds(-5), milliseconds(1)));
  EXPECT_EQ(*clock.ToSession(DeviceTime{}), ServerTime{seconds(2)});
}

TEST(StampClock, TakesTheLeastDelayAndFollowsJumps) {
  StampClock clock;
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(3)}), DeviceTime{seconds(3)});
  clock.Observe(DeviceTime{seconds(3)}, DeviceTime{seconds(100) + milliseconds(80)});
  clock.Observe(DeviceTime{seconds(4)}, DeviceTime{seconds(101) + milliseconds(5)});
  clock.Observe(DeviceTime{seconds(5)}, DeviceTime{seconds(102) + milliseconds(50)});
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(6)}), DeviceTime{seconds(103) + milliseconds(5)});
  clock.Observe(DeviceTime{seconds(6)}, DeviceTime{seconds(110)});
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(6)}), DeviceTime{seconds(110)}) << "it was paused";
  clock.Observe(DeviceTime{seconds(500)}, DeviceTime{seconds(111)});
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(500)}), DeviceTime{seconds(111)}) << "it was set";
}

}  // namespace
}  // namespace waymark::session
