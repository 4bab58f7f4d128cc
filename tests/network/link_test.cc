// SPDX-License-Identifier: Apache-2.0
#include "tests/network/link.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/network/profiles.h"

namespace waymark::network {
namespace {

using std::chrono::seconds;

constexpr Instant kStart{seconds(1000)};

/// Sends packets of so many bytes at even intervals.
std::vector<std::optional<Instant>> SendMany(Link& link, int count, std::size_t bytes,
                                             microseconds interval) {
  std::vector<std::optional<Instant>> out;
  for (int i = 0; i < count; ++i) out.push_back(link.Carry(bytes, kStart + i * interval));
  return out;
}

TEST(Link, TheDefaultCarriesEverythingAtOnce) {
  Link link({}, 1);
  EXPECT_EQ(link.Carry(1500, kStart), kStart);
}

TEST(Link, DelaysAndSpreads) {
  Link link({.delay = milliseconds(50), .jitter = milliseconds(10), .overtaking = 1}, 1);
  Instant::duration sum{}, least = seconds(9), most{};
  for (const auto& out : SendMany(link, 1000, 100, microseconds(0))) {
    const Instant::duration delay = *out - kStart;
    sum += delay;
    least = std::min(least, delay);
    most = std::max(most, delay);
  }
  EXPECT_GE(least, milliseconds(40));
  EXPECT_LT(least, milliseconds(41));
  EXPECT_LE(most, milliseconds(60));
  EXPECT_GT(most, milliseconds(59));
  EXPECT_NEAR(1e-6 * static_cast<double>((sum / 1000).count()), 50, 1);
}

TEST(Link, KeepsTheOrderUnlessToldOtherwise) {
  LinkOptions options{.delay = milliseconds(50), .jitter = milliseconds(30)};
  Link orderly(options, 1);
  const auto in_order = SendMany(orderly, 200, 100, milliseconds(1));
  EXPECT_TRUE(std::is_sorted(in_order.begin(), in_order.end()));
  options.overtaking = 0.1;
  Link wild(options, 1);
  const auto out_of_order = SendMany(wild, 200, 100, milliseconds(1));
  EXPECT_FALSE(std::is_sorted(out_of_order.begin(), out_of_order.end()));
}

TEST(Link, TheRateIsAQueueThatIsFullInTheEnd) {
  Link link({.rate_bps = 1e6, .queue = milliseconds(100)}, 1);  // 1,250 bytes take 10 ms
  const auto out = SendMany(link, 20, 1250, microseconds(0));
  for (int i = 0; i < 11; ++i) EXPECT_EQ(*out[i], kStart + (i + 1) * milliseconds(10)) << i;
  for (int i = 11; i < 20; ++i) EXPECT_FALSE(out[i]) << i;
  EXPECT_EQ(link.counters().dropped, 9u);
  EXPECT_EQ(link.Carry(1250, kStart + seconds(1)), kStart + seconds(1) + milliseconds(10));
}

TEST(Link, LosesItsShare) {
  Link steady({.loss = 0.1}, 7);
  (void)SendMany(steady, 10'000, 100, microseconds(0));
  EXPECT_NEAR(static_cast<double>(steady.counters().lost), 1000, 100);
  Link changing({.loss = 0.1, .worst_loss = 0.3}, 7);
  (void)SendMany(changing, 10'000, 100, milliseconds(10));
  EXPECT_NEAR(static_cast<double>(changing.counters().lost), 2000, 300);
}

TEST(Link, IsOutBySchedule) {
  Link link({.outage_every = seconds(10), .outage = seconds(2)}, 1);
  for (int second = 0; second < 30; ++second) {
    EXPECT_EQ(link.Carry(100, kStart + seconds(second)).has_value(), second % 10 < 8) << second;
  }
  link.Cut(true);
  EXPECT_FALSE(link.Carry(100, kStart + seconds(31)));
  link.Cut(false);
  EXPECT_TRUE(link.Carry(100, kStart + seconds(32)));
}

TEST(Link, TheSameSeedIsTheSameFate) {
  const Profile& crowded = *FindProfile("crowded");
  Link one(crowded.up, 42), same(crowded.up, 42), other(crowded.up, 43);
  const auto fate = SendMany(one, 500, 800, milliseconds(20));
  EXPECT_EQ(fate, SendMany(same, 500, 800, milliseconds(20)));
  EXPECT_NE(fate, SendMany(other, 500, 800, milliseconds(20)));
}

TEST(Profiles, AreFoundByName) {
  for (const char* name : {"none", "4g", "3g", "crowded"}) EXPECT_NE(FindProfile(name), nullptr);
  EXPECT_EQ(FindProfile("6g"), nullptr);
}

}  // namespace
}  // namespace waymark::network
