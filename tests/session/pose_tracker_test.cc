// SPDX-License-Identifier: Apache-2.0
#include "session/device/pose_tracker.h"

#include <gmock/gmock.h>

#include "tests/support/random_geometry.h"

namespace waymark::session {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;

TEST(PoseTracker, CarriesCovarianceAlongTheLever) {
  support::RandomGeometry random(8);
  const Rigid3 b_from_a = random.Rigid(), a_from_c = random.Rigid();
  const Eigen::Vector3d lever_in_b = b_from_a.rotation() * a_from_c.translation();
  // Against differences: column i of the factor is the response to a step in delta i.
  constexpr double kStep = 1e-6;
  Eigen::Matrix<double, 6, 6> response;
  for (int i = 0; i < 6; ++i) {
    Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
    delta(i) = kStep;
    response.col(i) = Difference(b_from_a * a_from_c, Perturb(b_from_a, delta) * a_from_c) / kStep;
  }
  const Eigen::Matrix<double, 6, 6> factor = Eigen::Matrix<double, 6, 6>::Random();
  const Eigen::Matrix<double, 6, 6> covariance = factor * factor.transpose();
  EXPECT_LT((CarryCovariance(covariance, lever_in_b) - response * covariance * response.transpose())
                .norm(),
            1e-3);
}

TEST(PoseTracker, AFixPlacesTheOdometryInTheMap) {
  support::RandomGeometry random(9);
  PoseTracker tracker({}, {});
  const Transform<Map, Vo> map_from_vo(
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ())), {4, 5, 6});
  const Transform<Device, Camera> device_from_camera(random.Rigid());
  const Transform<Vo, Device> then(Rigid3(Eigen::Quaterniond::Identity(), {1, 0, 0}));
  const Transform<Vo, Device> now(random.Rigid());
  EXPECT_FALSE(tracker.Pose(1).map_from_device);
  tracker.AddFix({.request = {},
                  .time = DeviceTime{seconds(1)},
                  .device_from_camera = device_from_camera,
                  .vo_from_device = then},
                 {.map_from_camera = map_from_vo * then * device_from_camera,
                  .covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-4,
                  .submap = SubmapId("s"),
                  .submap_from_camera = {},
                  .inliers = 50,
                  .rms_px = 1});
  EXPECT_FALSE(tracker.Pose(1).map_from_device) << "no odometry yet";
  tracker.PushOdometry(now, DeviceTime{seconds(2)});
  ASSERT_TRUE(tracker.Pose(1).map_from_device);
  EXPECT_LT(
      Difference(tracker.Pose(1).map_from_device->rigid(), (map_from_vo * now).rigid()).norm(),
      1e-6);
  EXPECT_THAT(tracker.SeenIn(), ElementsAre(SubmapId("s")));
  tracker.Reset();
  EXPECT_FALSE(tracker.Pose(1).map_from_device);
}

/// A phone that stands still, and where its fixes say that it is.
struct StandingPhone {
  explicit StandingPhone(const CorrectionOptions& correction)
      : tracker({.half_life = std::chrono::duration<double>(0.01)}, correction) {}

  /// So many fixes that agree on x, turned about the vertical.
  void Fix(int count, double x_m, double yaw_rad = 0) {
    for (int i = 0; i < count; ++i) {
      tracker.AddFix({.request = {},
                      .time = DeviceTime{std::chrono::nanoseconds(time) + milliseconds(i)},
                      .device_from_camera = {},
                      .vo_from_device = {}},
                     {.map_from_camera = {RotationFromVector({0, 0, yaw_rad}), {x_m, 0, 0}},
                      .covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-4,
                      .submap = SubmapId("s"),
                      .submap_from_camera = {},
                      .inliers = 50,
                      .rms_px = 1});
    }
  }
  /// Where it is shown a tenth of a second later.
  Rigid3 Live() {
    time += milliseconds(100);
    tracker.PushOdometry({}, DeviceTime{time});
    return tracker.Pose(1).map_from_device->rigid();
  }

  PoseTracker tracker;
  std::chrono::nanoseconds time = seconds(1);
};

// When a better estimate differs from one that was agreed upon, the shown pose walks there.
TEST(PoseTracker, CorrectionsNeverJump) {
  StandingPhone phone({.max_speed_mps = 0.5});
  phone.Fix(4, 10);
  double shown = phone.Live().translation().x();
  EXPECT_NEAR(shown, 10, 0.01);
  phone.Fix(4, 11);
  const double before = phone.tracker.Pose(1).covariance(0, 0);
  for (int i = 0; i < 40; ++i) {
    const double next = phone.Live().translation().x();
    EXPECT_LE(std::abs(next - shown), 0.5 * 0.1 + 1e-9);
    shown = next;
  }
  EXPECT_NEAR(shown, 11, 0.05);
  EXPECT_LT(phone.tracker.Pose(1).covariance(0, 0), before)
      << "what was still to come was uncertainty";
}

TEST(PoseTracker, ByDefaultContentWalksTenCentimetresAndTurnsThreeDegreesASecond) {
  StandingPhone phone({});
  phone.Fix(4, 10);
  Rigid3 shown = phone.Live();
  phone.Fix(4, 11, 0.2);
  double walked_m = 0, turned_rad = 0;
  for (int i = 0; i < 10; ++i) {
    const Rigid3 next = phone.Live();
    walked_m += (next.translation() - shown.translation()).norm();
    turned_rad += AngleBetween(next.rotation(), shown.rotation()).radians();
    shown = next;
  }
  EXPECT_LE(walked_m, 0.1 + 1e-9);
  EXPECT_LE(turned_rad, Angle::Degrees(3).radians() + 1e-9);
  EXPECT_GT(walked_m, 0.05) << "it does walk";
}

TEST(PoseTracker, JumpsWhileNothingWasEverAgreedUponAndWhenItWasWrongByMuch) {
  StandingPhone phone({});
  phone.Fix(1, 10);
  EXPECT_NEAR(phone.Live().translation().x(), 10, 1e-6);
  phone.Fix(4, 10.5);
  EXPECT_NEAR(phone.Live().translation().x(), 10.5, 0.01) << "agreed upon for the first time";
  phone.Fix(4, 11);
  EXPECT_NEAR(phone.Live().translation().x(), 10.51, 0.01) << "walks from now on";
  phone.Fix(4, 14);
  EXPECT_NEAR(phone.Live().translation().x(), 14, 0.01) << "more than two metres";
  phone.tracker.Reset();
  phone.Fix(1, 20);
  EXPECT_NEAR(phone.Live().translation().x(), 20, 1e-6) << "the odometry began anew";
}

TEST(PoseTracker, IsCarriedToAnotherReleaseAtOnceOrForgets) {
  PoseTracker tracker({}, {.max_speed_mps = 0.01});
  const Transform<Submap, Camera> submap_from_camera(Eigen::Quaterniond::Identity(), {3, 0, 0});
  tracker.AddFix({.request = {},
                  .time = DeviceTime{seconds(1)},
                  .device_from_camera = {},
                  .vo_from_device = {}},
                 {.map_from_camera = {Eigen::Quaterniond::Identity(), {3, 0, 0}},
                  .covariance = Eigen::Matrix<double, 6, 6>::Identity() * 1e-4,
                  .submap = SubmapId("s"),
                  .submap_from_camera = submap_from_camera,
                  .inliers = 50,
                  .rms_px = 1});
  tracker.PushOdometry({}, DeviceTime{seconds(2)});
  const Sim3 place(1, RotationFromVector({0, 0, 0.2}), {1, 2, 0});
  EXPECT_TRUE(tracker.CarryTo({{SubmapId("s"), Similarity<Map, Submap>(place)}}));
  ASSERT_TRUE(tracker.Pose(2).map_from_device);
  const Rigid3 expected = CarryPose(place, submap_from_camera.rigid());
  EXPECT_LT(Difference(tracker.Pose(2).map_from_device->rigid(), expected).norm(), 1e-9)
      << "a change of frame is no correction, which would walk";
  EXPECT_FALSE(tracker.CarryTo({}));
  EXPECT_FALSE(tracker.Pose(3).map_from_device);
}

}  // namespace
}  // namespace waymark::session
