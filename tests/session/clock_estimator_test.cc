// SPDX-License-Identifier: Apache-2.0
#include "session/device/clock_estimator.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <string>
#include <vector>

namespace waymark::session {
namespace {

using std::chrono::hours;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

/// A device whose clock is wrong and not of the right rate.
struct Device {
  nanoseconds ahead{0};  ///< of the session, at its beginning
  double gain = 0;       ///< seconds that it gains in a second

  DeviceTime At(ServerTime instant) const {
    const nanoseconds age = instant.time_since_epoch();
    return DeviceTime(age + ahead + std::chrono::round<nanoseconds>(gain * age));
  }
  ClockExchange Exchange(ServerTime sent, nanoseconds up, nanoseconds down) const {
    const ServerTime received = sent + up, replied = received + milliseconds(1);
    return {At(sent), received, replied, At(replied + down)};
  }
};

constexpr ServerTime kStart{seconds(1000)};

double ErrorMs(const ClockEstimator& clock, const Device& device, ServerTime now) {
  return 1e3 * std::abs(Seconds(*clock.ToSession(device.At(now)) - now));
}

TEST(ClockEstimator, BelievesTheExchangeWithTheLeastDelay) {
  const Device device{.ahead = seconds(12345)};
  ClockEstimator clock;
  EXPECT_FALSE(clock.ToSession(DeviceTime{}));
  EXPECT_FALSE(clock.Delay());
  clock.Add(device.Exchange(kStart, milliseconds(90), milliseconds(10)));
  EXPECT_NEAR(ErrorMs(clock, device, kStart), 40, 0.1) << "half the difference of the ways";
  clock.Add(device.Exchange(kStart + milliseconds(250), milliseconds(5), milliseconds(5)));
  clock.Add(device.Exchange(kStart + milliseconds(500), milliseconds(5), milliseconds(500)));
  EXPECT_LT(ErrorMs(clock, device, kStart), 0.1);
  EXPECT_EQ(*clock.Delay(), milliseconds(10));
  EXPECT_EQ(clock.jumps(), 0);
}

TEST(ClockEstimator, FollowsADriftAndSaysHowLarge) {
  const Device device{.ahead = seconds(-7), .gain = 80e-6};
  ClockEstimator clock;
  ServerTime now = kStart;
  for (int i = 0; i < 240; ++i) {
    now = kStart + i * milliseconds(250);
    clock.Add(device.Exchange(now, milliseconds(20), milliseconds(20)));
  }
  EXPECT_NEAR(clock.Drift(), -80e-6, 4e-6);
  EXPECT_LT(ErrorMs(clock, device, now), 0.1);
  EXPECT_LT(ErrorMs(clock, device, now + seconds(10)), 0.3) << "where there is nothing to hear";
}

TEST(ClockEstimator, IgnoresTheImpossible) {
  const Device device;
  ClockEstimator clock;
  clock.Add(device.Exchange(kStart, milliseconds(1), milliseconds(1)));
  clock.Add(device.Exchange(kStart, milliseconds(-5), milliseconds(1)));
  EXPECT_LT(ErrorMs(clock, device, kStart), 0.1);
}

TEST(ClockEstimator, AClockThatWasSetIsFoundByTheFirstExchangeAfterIt) {
  for (const nanoseconds jump : {nanoseconds(hours(1)), nanoseconds(-hours(1)),
                                 nanoseconds(milliseconds(300)), nanoseconds(-milliseconds(300))}) {
    Device device{.ahead = hours(3)};
    ClockEstimator clock;
    ServerTime now = kStart;
    for (int i = 0; i < 100; ++i, now += milliseconds(250)) {
      clock.Add(device.Exchange(now, milliseconds(40), milliseconds(40)));
    }
    // The one under way when it was set is wrong either way, and does no harm.
    ClockExchange torn = device.Exchange(now, milliseconds(40), milliseconds(40));
    torn.device_received += jump;
    clock.Add(torn);
    EXPECT_LT(ErrorMs(clock, device, now), 1);
    device.ahead += jump;
    now += milliseconds(250);
    clock.Add(device.Exchange(now, milliseconds(40), milliseconds(60)));
    EXPECT_EQ(clock.jumps(), 1) << jump.count();
    EXPECT_LE(ErrorMs(clock, device, now), 10.1) << "as good as one exchange is";
  }
}

TEST(ClockEstimator, ALongSilenceIsNoJump) {
  const Device device{.ahead = seconds(1), .gain = 100e-6};
  ClockEstimator clock;
  for (int i = 0; i < 40; ++i) {
    clock.Add(device.Exchange(kStart + i * milliseconds(250), milliseconds(2), milliseconds(2)));
  }
  const ServerTime later = kStart + seconds(70);
  clock.Add(device.Exchange(later, milliseconds(2), milliseconds(2)));
  EXPECT_EQ(clock.jumps(), 0);
  EXPECT_LT(ErrorMs(clock, device, later), 0.5);
}

struct Delays {
  microseconds up, down;
};

/// Recorded by record_delays, while images went up on the same connection.
std::vector<Delays> LoadTrace(const std::string& name) {
  std::ifstream file(std::string(SESSION_TEST_DATA "/") + name);
  std::vector<Delays> trace;
  for (std::int64_t up = 0, down = 0; file >> up >> down;) {
    trace.push_back({microseconds(up), microseconds(down)});
  }
  return trace;
}

/// What 95 of 100 instants are not farther off than, once the first quick exchanges are over.
double Percentile95Ms(const std::vector<Delays>& trace, double gain) {
  constexpr std::size_t kFirst = 8;
  const Device device{.ahead = seconds(-123), .gain = gain};
  ClockEstimator clock;
  std::vector<double> errors_ms;
  for (std::size_t i = 0; i < trace.size(); ++i) {
    const ServerTime now = kStart + i * milliseconds(250);
    clock.Add(device.Exchange(now, trace[i].up, trace[i].down));
    if (i >= kFirst) errors_ms.push_back(ErrorMs(clock, device, now + milliseconds(125)));
  }
  EXPECT_EQ(clock.jumps(), 0) << "delay is no jump";
  std::sort(errors_ms.begin(), errors_ms.end());
  return errors_ms[errors_ms.size() * 95 / 100];
}

TEST(ClockEstimator, IsGoodTo5MsOn4gWhileImagesGoUp) {
  const auto trace = LoadTrace("delays_4g.txt");
  ASSERT_EQ(trace.size(), 480u);
  for (const double gain : {-80e-6, 0.0, 30e-6}) EXPECT_LE(Percentile95Ms(trace, gain), 5) << gain;
}

TEST(ClockEstimator, IsGoodTo15MsOn3gWhileImagesGoUp) {
  const auto trace = LoadTrace("delays_3g.txt");
  ASSERT_EQ(trace.size(), 480u);
  for (const double gain : {-80e-6, 0.0, 30e-6}) EXPECT_LE(Percentile95Ms(trace, gain), 15) << gain;
}

TEST(StampClock, TakesTheLeastDelayAndFollowsJumps) {
  StampClock clock;
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(3)}), DeviceTime{seconds(3)});
  EXPECT_FALSE(clock.Observe(DeviceTime{seconds(3)}, DeviceTime{seconds(100) + milliseconds(80)}));
  EXPECT_FALSE(clock.Observe(DeviceTime{seconds(4)}, DeviceTime{seconds(101) + milliseconds(5)}));
  EXPECT_FALSE(clock.Observe(DeviceTime{seconds(5)}, DeviceTime{seconds(102) + milliseconds(50)}));
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(6)}), DeviceTime{seconds(103) + milliseconds(5)});
  const auto paused = clock.Observe(DeviceTime{seconds(6)}, DeviceTime{seconds(110)});
  EXPECT_EQ(paused, -(seconds(7) - milliseconds(5)));
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(6)}), DeviceTime{seconds(110)});
  const auto set = clock.Observe(DeviceTime{seconds(3607)}, DeviceTime{seconds(111)});
  EXPECT_EQ(set, hours(1));
  EXPECT_EQ(clock.ToSteady(DeviceTime{seconds(3607)}), DeviceTime{seconds(111)});
}

}  // namespace
}  // namespace waymark::session
