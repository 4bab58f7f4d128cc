// SPDX-License-Identifier: Apache-2.0
#include "session/device/remote_track.h"
#include "mapping/base/quantile.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/session/playout_simulation.h"

namespace waymark::session {
namespace {

using std::chrono::milliseconds;

constexpr ServerTime kStart{std::chrono::hours(1)};

LivePose Walking(milliseconds since_start, double speed_mps = 1.5) {
  return {
      .epoch = 1,
      .time = kStart + since_start,
      .map_from_device = {Eigen::Quaterniond::Identity(), {speed_mps * Seconds(since_start), 0, 0}},
      .sigma_m = 0.05,
      .velocity_in_map = {speed_mps, 0, 0}};
}

double X(const RemoteTrack& track, milliseconds since_start) {
  return track.At(kStart + since_start)->map_from_device.translation().x();
}

TEST(RemoteTrack, WhoWalksOnIsShownWhereHeIsNow) {
  RemoteTrack track;
  for (int i = 0; i < 60; ++i)
    track.Hear(Walking(33 * milliseconds(i)), kStart + 33 * milliseconds(i) + milliseconds(60));
  const milliseconds now(59 * 33 + 60);
  EXPECT_EQ(track.delay().count(), 0);
  EXPECT_NEAR(X(track, now), 1.5 * Seconds(now), 0.01) << "though the report is 60 ms old";
  EXPECT_NEAR(X(track, now), X(track, now + milliseconds(1)), 0.002);
}

TEST(RemoteTrack, WhatIsUnheardSlowsDownAndIsLessCertain) {
  RemoteTrack track;
  track.Hear(Walking(milliseconds(0)), kStart);
  double before_m = 0, before_sigma_m = 0;
  for (const int ms : {0, 100, 300, 1000, 3000, 60'000}) {
    const auto shown = track.At(kStart + milliseconds(ms));
    EXPECT_GE(shown->map_from_device.translation().x(), before_m);
    EXPECT_GE(shown->sigma_m, before_sigma_m);
    before_m = shown->map_from_device.translation().x();
    before_sigma_m = shown->sigma_m;
  }
  EXPECT_LE(before_m, 3) << "two seconds' way at most";
  EXPECT_GT(before_sigma_m, 10);
}

TEST(RemoteTrack, ANewReportDoesNotMakeItJump) {
  RemoteTrack track;
  for (int i = 0; i < 30; ++i)
    track.Hear(Walking(33 * milliseconds(i)), kStart + 33 * milliseconds(i));
  LivePose aside = Walking(milliseconds(30 * 33));
  aside.map_from_device = {Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())),
                           aside.map_from_device.translation() + Eigen::Vector3d(0, 0.2, 0)};
  const ServerTime arrived = kStart + milliseconds(30 * 33 + 10);
  const Rigid3 before = track.At(arrived)->map_from_device.rigid();
  track.Hear(aside, arrived);
  EXPECT_LT(Difference(track.At(arrived)->map_from_device.rigid(), before).norm(), 1e-9);
  const Rigid3 settled = track.At(arrived + milliseconds(500))->map_from_device.rigid();
  EXPECT_NEAR(settled.translation().y(), 0.2, 0.005);
}

TEST(RemoteTrack, LateAndTwiceIsAsGood) {
  RemoteTrack in_order, shuffled;
  for (const int i : {0, 1, 2, 3, 4})
    in_order.Hear(Walking(milliseconds(40 * i)), kStart + milliseconds(300));
  for (const int i : {4, 0, 2, 2, 1, 3})
    shuffled.Hear(Walking(milliseconds(40 * i)), kStart + milliseconds(300));
  for (const int ms : {500, 900})
    EXPECT_NEAR(X(in_order, milliseconds(ms)), X(shuffled, milliseconds(ms)), 0.01);
}

TEST(RemoteTrack, AnotherEpochBeginsAnew) {
  RemoteTrack track;
  track.Hear(Walking(milliseconds(0)), kStart);
  LivePose carried = Walking(milliseconds(33));
  carried.epoch = 2;
  carried.map_from_device = {Eigen::Quaterniond::Identity(), {100, 0, 0}};
  track.Hear(carried, kStart + milliseconds(33));
  EXPECT_EQ(X(track, milliseconds(33)), 100) << "at once: it is another frame";
  track.Hear(Walking(milliseconds(20)), kStart + milliseconds(40));
  EXPECT_EQ(track.latest()->epoch, 2u) << "what crossed on the way does not count";
}

TEST(RemoteTrack, BeforeTheClockIsKnownTheNewestIsShown) {
  RemoteTrack track;
  EXPECT_FALSE(track.At(kStart));
  track.Hear(Walking(milliseconds(0)), ServerTime{});
  track.Hear(Walking(milliseconds(100)), ServerTime{});
  EXPECT_NEAR(track.At(ServerTime{})->map_from_device.translation().x(), 0.15, 1e-9);
  EXPECT_EQ(track.delay().count(), 0);
}

TEST(RemoteTrack, ANetworkThatIsLateIsWaitedFor) {
  RemoteTrack track;
  for (int i = 0; i < 300; ++i) {
    const milliseconds late(i % 2 == 0 ? 150 : 870);
    track.Hear(Walking(33 * milliseconds(i)), kStart + 33 * milliseconds(i) + late);
  }
  EXPECT_NEAR(track.delay().count(), 0.07, 0.02) << "by what is later than the horizon";
}

double BeyondThree_percent(const std::vector<double>& sigmas) {
  const auto beyond = std::ranges::count_if(sigmas, [](double s) { return s > 3; });
  return 100.0 * static_cast<double>(beyond) / static_cast<double>(sigmas.size());
}

TEST(RemoteTrack, IsNearerToTheTruthThanTheLatestReportOnMobileNetworks) {
  for (support::NetworkProfile profile :
       {support::FourG(), support::ThreeG(), support::Crowded()}) {
    for (const bool is_stream : {false, true}) {
      profile.is_stream = is_stream;
      const auto errors = support::SimulatePlayout(profile, {}, 11);
      const auto print = [&](const char* name, const support::DisplayErrors& shown) {
        fmt::print(
            "{:<8} {:<9} {:<7} position p50 {:5.1f} p95 {:5.1f} cm, rotation p50 {:4.2f} p95 "
            "{:5.2f} "
            "deg, from frame to frame p95 {:4.1f} cm, beyond 3 sigma {:.2f} % and {:.2f} %\n",
            profile.name, is_stream ? "stream" : "datagrams", name,
            100 * Quantile(shown.position_m, 0.5), 100 * Quantile(shown.position_m, 0.95),
            57.2958 * Quantile(shown.rotation_rad, 0.5),
            57.2958 * Quantile(shown.rotation_rad, 0.95), 100 * Quantile(shown.jump_m, 0.95),
            BeyondThree_percent(shown.per_sigma), BeyondThree_percent(shown.rotation_per_sigma));
      };
      print("latest", errors.latest);
      print("track", errors.track);
      EXPECT_LT(Quantile(errors.track.position_m, 0.5),
                0.6 * Quantile(errors.latest.position_m, 0.5))
          << profile.name;
      EXPECT_LT(Quantile(errors.track.position_m, 0.95), Quantile(errors.latest.position_m, 0.95))
          << profile.name;
      EXPECT_LT(Quantile(errors.track.jump_m, 0.95), Quantile(errors.latest.jump_m, 0.95))
          << profile.name;
      EXPECT_LT(Quantile(errors.track.rotation_rad, 0.95),
                Quantile(errors.latest.rotation_rad, 0.95))
          << profile.name;
      EXPECT_LT(Quantile(errors.track.rotation_rad, 0.5),
                1.05 * Quantile(errors.latest.rotation_rad, 0.5))
          << profile.name;
      EXPECT_LT(BeyondThree_percent(errors.track.per_sigma), 1) << profile.name;
      EXPECT_LT(BeyondThree_percent(errors.track.rotation_per_sigma), 8) << profile.name;
    }
  }
}

}  // namespace
}  // namespace waymark::session
