// SPDX-License-Identifier: Apache-2.0
#include "session/device/internal/burst_desk.h"

#include <gmock/gmock.h>

#include <limits>
#include <numbers>

#include "tests/session/pictured_map.h"

namespace waymark::session::internal {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::IsEmpty;

Transform<Vo, Device> At(double x_m, double yaw_rad = 0) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ())), {x_m, 0, 0}};
}

/// A phone that walks along x at 1 m/s, with odometry ten times and a keyframe once a second.
class ABurstDesk : public testing::Test {
 protected:
  explicit ABurstDesk(int max_images = 3) : desk_(max_images) {}

  void WalkTo(double x_m) {
    while (x_m_ < x_m - 1e-9) {
      x_m_ += 0.1;
      time_ += milliseconds(100);
      desk_.Observe(At(x_m_), time_);
    }
  }

  LocaliseQuery Ask(std::uint32_t request, const Transform<Vo, Device>& vo_from_device) {
    LocaliseQuery query{.request = RequestNumber{request},
                        .time = time_,
                        .camera = support::TestCamera(),
                        .prior = std::nullopt,
                        .up_in_camera = std::nullopt,
                        .image = {}};
    desk_.Ask({.width_px = 0,
               .height_px = 0,
               .pixels = {},
               .camera = support::TestCamera(),
               .device_from_camera = {},
               .vo_from_device = vo_from_device,
               .time = time_},
              query);
    return query;
  }

  /// Walks there, asks, and hears that.
  LocaliseQuery AskAt(double x_m, std::uint32_t request,
                      LocaliseStatus status = LocaliseStatus::kTooFewMatches) {
    WalkTo(x_m);
    const LocaliseQuery query = Ask(request, At(x_m_));
    desk_.OnAnswer(query.request, status);
    return query;
  }

  static std::vector<int> Requests(const LocaliseQuery& query) {
    std::vector<int> requests;
    for (const auto& earlier : query.earlier) requests.push_back(static_cast<int>(earlier.request));
    return requests;
  }

  BurstDesk desk_;
  double x_m_ = 0;
  DeviceTime time_{seconds(100)};
};

TEST_F(ABurstDesk, NamesTheNewestThatWereNotFound) {
  EXPECT_THAT(Requests(AskAt(1, 1)), IsEmpty());
  EXPECT_THAT(Requests(AskAt(2, 2, LocaliseStatus::kTooFewFeatures)), ElementsAre(1));
  EXPECT_THAT(Requests(AskAt(3, 3, LocaliseStatus::kNoConsistentPose)), ElementsAre(1, 2));
  const LocaliseQuery query = AskAt(4, 4);
  EXPECT_THAT(Requests(query), ElementsAre(2, 3));
  EXPECT_DOUBLE_EQ(query.vo_from_camera->translation().x(), x_m_);
  EXPECT_NEAR(query.earlier.back().vo_from_camera.translation().x(), 3, 1e-9);
}

TEST_F(ABurstDesk, WhatWasFoundCountsOnceAndWhatWasNotLookedAtNever) {
  AskAt(1, 1);
  AskAt(2, 2, LocaliseStatus::kLocalised);
  EXPECT_THAT(Requests(AskAt(3, 3, LocaliseStatus::kBusy)), IsEmpty());
  EXPECT_THAT(Requests(AskAt(4, 4, LocaliseStatus::kNothingNear)), IsEmpty());
  EXPECT_THAT(Requests(AskAt(5, 5, LocaliseStatus::kInvalidImage)), IsEmpty());
  EXPECT_THAT(Requests(AskAt(6, 6)), IsEmpty());
}

TEST_F(ABurstDesk, AnAnswerToAnotherImageSaysNothing) {
  WalkTo(1);
  Ask(1, At(1));
  desk_.OnAnswer(RequestNumber{9}, LocaliseStatus::kTooFewMatches);
  WalkTo(2);
  Ask(2, At(2));  // 1 was given up
  desk_.OnAnswer(RequestNumber{1}, LocaliseStatus::kTooFewMatches);
  EXPECT_THAT(Requests(AskAt(3, 3)), IsEmpty());
}

TEST_F(ABurstDesk, WhoStandsStillSeesNothingNew) {
  AskAt(1, 1);
  EXPECT_THAT(Requests(Ask(2, At(1.05))), IsEmpty());
  desk_.OnAnswer(RequestNumber{2}, LocaliseStatus::kBusy);
  EXPECT_THAT(Requests(Ask(3, At(1.05))), IsEmpty());
  desk_.OnAnswer(RequestNumber{3}, LocaliseStatus::kTooFewMatches);
  EXPECT_THAT(Requests(AskAt(2, 4)), ElementsAre(3)) << "it took the place of 1";
}

TEST_F(ABurstDesk, WhatIsFarBackOrLongAgoIsForgotten) {
  AskAt(1, 1);
  AskAt(9, 2);
  EXPECT_THAT(Requests(AskAt(17, 3)), ElementsAre(2)) << "16 m of odometry since 1";
  for (int i = 0; i < 21; ++i) {
    time_ += seconds(1);
    desk_.Observe(At(x_m_), time_);
  }
  EXPECT_THAT(Requests(AskAt(18, 4)), IsEmpty());
}

TEST_F(ABurstDesk, TheWayThereAndBackCounts) {
  AskAt(1, 1);
  WalkTo(9);
  for (double x_m = 9; x_m > 1; x_m -= 0.1) {
    time_ += milliseconds(100);
    desk_.Observe(At(x_m), time_);
  }
  EXPECT_THAT(Requests(Ask(2, At(1))), IsEmpty());
}

TEST_F(ABurstDesk, ALeapOfOdometryEndsIt) {
  for (const auto& leap :
       {At(5), At(2, std::numbers::pi / 2), At(std::numeric_limits<double>::quiet_NaN())}) {
    AskAt(x_m_ + 1, 1);
    Ask(2, At(x_m_));  // under way meanwhile
    time_ += milliseconds(33);
    desk_.Observe(leap, time_);
    time_ += milliseconds(1);
    desk_.Observe(At(x_m_), time_);
    desk_.OnAnswer(RequestNumber{2}, LocaliseStatus::kTooFewMatches);
    EXPECT_THAT(Requests(Ask(3, At(x_m_))), IsEmpty());
  }
}

TEST_F(ABurstDesk, AFrameFromBeforeALeapHasNoOdometry) {
  AskAt(1, 1);
  const DeviceTime taken = time_;
  desk_.Observe(At(30), time_ + milliseconds(33));
  time_ = taken;
  EXPECT_FALSE(Ask(2, At(1)).vo_from_camera);
}

TEST_F(ABurstDesk, AFrameHandedOverLateIsNoLeap) {
  AskAt(1, 1);
  WalkTo(2);
  desk_.Observe(At(1.8), time_ - milliseconds(200));
  EXPECT_THAT(Requests(Ask(2, At(2))), ElementsAre(1));
}

TEST_F(ABurstDesk, ALongSilenceEndsIt) {
  AskAt(1, 1);
  time_ += milliseconds(2100);
  EXPECT_THAT(Requests(AskAt(1.1, 2)), IsEmpty());
}

TEST_F(ABurstDesk, AClockThatIsSetChangesNothing) {
  AskAt(1, 1);
  desk_.ShiftTime(std::chrono::hours(1));
  time_ += std::chrono::hours(1);
  EXPECT_THAT(Requests(AskAt(2, 2)), ElementsAre(1));
}

TEST_F(ABurstDesk, AServerThatKnowsNothingIsNotAskedForIt) {
  AskAt(1, 1);
  desk_.Forget();
  EXPECT_THAT(Requests(AskAt(2, 2)), IsEmpty());
}

TEST_F(ABurstDesk, OdometryThatTheWireRefusesIsNotTold) {
  desk_.Observe(At(1), time_);
  EXPECT_FALSE(Ask(1, At(std::numeric_limits<double>::quiet_NaN())).vo_from_camera);
  EXPECT_FALSE(Ask(2, At(2e6)).vo_from_camera);
}

class ADeskOfOne : public ABurstDesk {
 protected:
  ADeskOfOne() : ABurstDesk(1) {}
};

TEST_F(ADeskOfOne, SaysNothingAtAll) {
  AskAt(1, 1);
  const LocaliseQuery query = AskAt(2, 2);
  EXPECT_FALSE(query.vo_from_camera);
  EXPECT_THAT(query.earlier, IsEmpty());
}

}  // namespace
}  // namespace waymark::session::internal
