// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mapping/pipeline/internal/gnss_track.h"
#include "mapping/pipeline/internal/inertial.h"
#include "mapping/pipeline/internal/levelling.h"

namespace waymark::mapping {
namespace {

SensorTime At(double seconds) { return FromNanoseconds<SensorTime>(std::llround(seconds * 1e9)); }

const GeoPoint kOrigin{Angle::Degrees(48), Angle::Degrees(11), 500};

GnssRecord FixAt(double seconds, const Eigen::Vector3d& position) {
  return {At(seconds), "gps0", TangentPlane(kOrigin).ToGeo(Point<Map>(position)), 1.0};
}

TEST(GnssTrack, InterpolatesAndDoubtsInTheMiddle) {
  const std::vector<GnssRecord> records{FixAt(0, {0, 0, 0}), FixAt(1, {10, 0, 0}),
                                        FixAt(11, {110, 0, 0})};
  const GnssTrack track(records, TangentPlane(kOrigin), {});
  const auto at_fix = track.FindPosition(At(1));
  ASSERT_TRUE(at_fix);
  EXPECT_NEAR(at_fix->position.coordinates().x(), 10, 1e-6);
  EXPECT_DOUBLE_EQ(at_fix->sigma_m, 1);
  const auto between = track.FindPosition(At(0.5));
  ASSERT_TRUE(between);
  EXPECT_NEAR(between->position.coordinates().x(), 5, 1e-6);
  EXPECT_NEAR(between->sigma_m, std::hypot(std::sqrt(0.5), 0.25), 1e-9);
  EXPECT_GT(track.FindPosition(At(6))->sigma_m, 20) << "five seconds from either fix";
}

TEST(GnssTrack, ExtrapolatesOnlyALittle) {
  const std::vector<GnssRecord> records{FixAt(0, {0, 0, 0}), FixAt(1, {10, 0, 0})};
  const GnssTrack track(records, TangentPlane(kOrigin), {});
  EXPECT_NEAR(track.FindPosition(At(1.5))->position.coordinates().x(), 15, 1e-5);
  EXPECT_GT(track.FindPosition(At(1.5))->sigma_m, 1.5);
  EXPECT_NEAR(track.FindPosition(At(-0.5))->position.coordinates().x(), -5, 1e-5);
  EXPECT_FALSE(track.FindPosition(At(2.5)));
  EXPECT_FALSE(track.FindPosition(At(-1.5)));
  EXPECT_FALSE(GnssTrack({}, TangentPlane(kOrigin), {}).FindPosition(At(0)));
}

TEST(Inertial, ComposesRigs) {
  const Rigid3 camera_from_rig(RotationFromVector({0.1, 0.2, 0.3}), {1, 2, 3});
  const Rigid3 imu_from_rig(RotationFromVector({-0.3, 0.1, 0.2}), {0, 1, 0});
  const std::vector<RigMember> rigs{
      {"rig", "cam", camera_from_rig}, {"rig", "imu", imu_from_rig}, {"other", "cam2", Rigid3()}};
  const auto found = FindSensorFromSensor(rigs, "cam", "imu");
  ASSERT_TRUE(found);
  const Eigen::Vector3d in_rig(4, 5, 6);
  EXPECT_NEAR((*found * (imu_from_rig * in_rig) - camera_from_rig * in_rig).norm(), 0, 1e-12);
  EXPECT_FALSE(FindSensorFromSensor(rigs, "cam2", "imu"));
}

TEST(Inertial, IntegratesAConstantTurn) {
  std::vector<ImuRecord> gyroscope;
  for (int i = 0; i <= 200; ++i) gyroscope.push_back({At(0.01 * i), "gyro", {0, 0, 0.5}});
  const auto turned = IntegrateRotation(gyroscope, At(0.3), At(1.3));
  ASSERT_TRUE(turned);
  // The sensor turned by +0.5 rad about z, so old axes are seen turned by -0.5.
  EXPECT_NEAR(AngleBetween(*turned, RotationFromVector({0, 0, -0.5})).radians(), 0, 1e-9);
  EXPECT_FALSE(IntegrateRotation(gyroscope, At(1.5), At(2.5))) << "beyond the recording";
  gyroscope.erase(gyroscope.begin() + 50, gyroscope.begin() + 80);
  EXPECT_FALSE(IntegrateRotation(gyroscope, At(0.3), At(1.3))) << "a gap";
  EXPECT_FALSE(IntegrateRotation({}, At(0), At(1)));
}

TEST(Inertial, UpAtRestIsNotBelievedInATurn) {
  std::vector<ImuRecord> force, still, turning;
  for (int i = 0; i <= 100; ++i) {
    force.push_back({At(0.01 * i), "acc", {0, 0.3, 9.79}});
    still.push_back({At(0.01 * i), "gyro", {0, 0, 0.01}});
    turning.push_back({At(0.01 * i), "gyro", {0, 0, 0.4}});
  }
  const auto up = FindUpAtRest(force, still, At(0.5));
  ASSERT_TRUE(up);
  EXPECT_NEAR(std::asin(up->y()), 0.0306, 1e-3);
  EXPECT_FALSE(FindUpAtRest(force, turning, At(0.5)));
  EXPECT_FALSE(FindUpAtRest(force, still, At(9)));
}

/// A car that weaves and changes its speed, with a tilted IMU.
struct WeavingDrive {
  std::vector<ImuRecord> accelerometer, gyroscope;
  std::vector<GnssFix> fixes;
  Eigen::Quaterniond mount = RotationFromVector({0.3, -0.2, 1.0});  // sensor from body

  static double Heading(double t) { return 0.6 * std::sin(0.4 * t); }
  static Eigen::Vector3d Velocity(double t) {
    const double speed = 10 + 3 * std::sin(0.25 * t);
    return {speed * std::cos(Heading(t)), speed * std::sin(Heading(t)), 0};
  }
  Eigen::Quaterniond SensorFromMap(double t) const {
    return mount * Eigen::Quaterniond(Eigen::AngleAxisd(-Heading(t), Eigen::Vector3d::UnitZ()));
  }
  Eigen::Vector3d Up(double t) const { return SensorFromMap(t) * Eigen::Vector3d::UnitZ(); }

  explicit WeavingDrive(double seconds) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> noise(0, 1);
    const auto noise3 = [&](double sigma) {
      return Eigen::Vector3d(sigma * noise(random), sigma * noise(random), sigma * noise(random));
    };
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    constexpr double kStep = 0.01;
    for (int i = 0; i * kStep <= seconds; ++i) {
      const double t = i * kStep;
      const Eigen::Vector3d acceleration = (Velocity(t + 1e-4) - Velocity(t - 1e-4)) / 2e-4;
      const double rate = (Heading(t + 1e-4) - Heading(t - 1e-4)) / 2e-4;
      accelerometer.push_back(
          {At(t), "acc",
           SensorFromMap(t) * (acceleration + Eigen::Vector3d(0, 0, 9.80665)) + noise3(0.05)});
      gyroscope.push_back({At(t), "gyro", mount * Eigen::Vector3d(0, 0, rate) + noise3(0.002)});
      if (i % 100 == 0) fixes.push_back({At(t), position + noise3(1), 1.0});
      position += kStep * Velocity(t + kStep / 2);
    }
  }
};

TEST(Levelling, FindsUpWhileTheVehicleWeaves) {
  const WeavingDrive drive(60);
  const Levelling levelling(drive.accelerometer, drive.gyroscope, drive.fixes, {});
  double worst_rad = 0, worst_felt_rad = 0;
  for (double t = 0.5; t < 59.5; t += 0.25) {
    const auto up = levelling.FindUp(At(t));
    ASSERT_TRUE(up) << t;
    worst_rad = std::max(worst_rad, std::acos(std::min(1.0, up->dot(drive.Up(t)))));
    const Eigen::Vector3d felt = drive.accelerometer[static_cast<std::size_t>(100 * t)].value;
    worst_felt_rad = std::max(worst_felt_rad, std::acos(felt.normalized().dot(drive.Up(t))));
  }
  EXPECT_LT(worst_rad, 0.03);
  EXPECT_GT(worst_felt_rad, 0.2) << "the test would be too easy";
}

TEST(Levelling, SaysNothingWithTooLittle) {
  const WeavingDrive drive(60);
  const auto fixes = std::span(drive.fixes).first(3);
  EXPECT_FALSE(Levelling(drive.accelerometer, drive.gyroscope, fixes, {}).FindUp(At(10)));
  EXPECT_FALSE(Levelling(drive.accelerometer, {}, drive.fixes, {}).FindUp(At(10)));
  EXPECT_FALSE(Levelling({}, drive.gyroscope, drive.fixes, {}).FindUp(At(10)));
  const Levelling whole(drive.accelerometer, drive.gyroscope, drive.fixes, {});
  EXPECT_FALSE(whole.FindUp(At(100)));
}

TEST(Levelling, DistrustsFixesThatNoMotionExplains) {
  WeavingDrive drive(30);
  for (std::size_t i = 0; i < drive.fixes.size(); ++i) {
    drive.fixes[i].position_in_map.x() += i % 2 == 0 ? 40 : -40;
  }
  EXPECT_FALSE(Levelling(drive.accelerometer, drive.gyroscope, drive.fixes, {}).FindUp(At(10)));
}

}  // namespace
}  // namespace waymark::mapping
