// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cmath>

#include "examples/simulator/motion/travel.h"
#include "examples/simulator/sensors/inertial.h"
#include "examples/simulator/sensors/odometry.h"
#include "examples/simulator/sensors/satellite.h"
#include "tests/examples/simulator/small_world.h"

namespace waymark::simulator {
namespace {

using Eigen::Vector3d;

constexpr InertialOptions kPerfectUnit{.rate_hz = 200,
                                       .accelerometer_noise = 0,
                                       .accelerometer_bias = 0,
                                       .gyroscope_noise = 0,
                                       .gyroscope_bias = 0};

Motion AtRest() {
  return Motion(CubicSpline<3>(std::vector<Vector3d>(6, Vector3d(3, 4, 5)), 1, -1),
                CubicSpline<2>(std::vector<Eigen::Vector2d>(6, {0.7, 0}), 1, -1), {});
}

City EmptyCity() { return City{{}, {{{0, 0}, {52, 40}}}, {}, {}, {}, {}}; }

Travel TestWalk(std::uint64_t seed) {
  return MakeWalk(EmptyCity(), {}, {}, Pavement::kInner, Turning::kCounterClockwise, Random(seed));
}

TEST(Inertial, AtRestTheAccelerometerMeasuresGravityUpwards) {
  for (const InertialSample& sample : MeasureInertial(AtRest(), {0, 1}, kPerfectUnit, Random(1))) {
    EXPECT_LT((sample.specific_force - Vector3d(0, 0, kGravity)).norm(), 1e-9);
    EXPECT_LT(sample.angular_velocity.norm(), 1e-9);
  }
}

TEST(Inertial, TurningLeftIsPositiveAboutUp) {
  const Travel drive = MakeDrive(EmptyCity(), {}, Random(1));  // counter-clockwise: one left turn
  double turned = 0;
  for (const InertialSample& sample :
       MeasureInertial(drive.motion, {0, drive.duration_s}, kPerfectUnit, Random(1))) {
    turned += sample.angular_velocity.z() / kPerfectUnit.rate_hz;
  }
  EXPECT_NEAR(turned, std::acos(0.0), 0.05);
}

TEST(Inertial, IntegratesToTheTrajectory) {
  for (const Travel& travel : {MakeDrive(EmptyCity(), {}, Random(1)), TestWalk(2)}) {
    const auto samples = MeasureInertial(travel.motion, {0, 8}, kPerfectUnit, Random(1));
    Rigid3 pose = travel.motion.WorldFromBody(0);
    Vector3d velocity = travel.motion.VelocityInWorld(0);
    const double step_s = 1 / kPerfectUnit.rate_hz;
    for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
      const InertialSample& a = samples[i];
      const InertialSample& b = samples[i + 1];
      const Eigen::Quaterniond next =
          pose.rotation() *
          RotationFromVector(step_s / 2 * (a.angular_velocity + b.angular_velocity));
      const Vector3d acceleration =
          (pose.rotation() * a.specific_force + next * b.specific_force) / 2 -
          Vector3d(0, 0, kGravity);
      pose =
          Rigid3(next, pose.translation() + step_s * velocity + step_s * step_s / 2 * acceleration);
      velocity += step_s * acceleration;
    }
    const Rigid3 truth = travel.motion.WorldFromBody(samples.back().time_s);
    EXPECT_LT((pose.translation() - truth.translation()).norm(), 0.02);
    EXPECT_LT(AngleBetween(pose.rotation(), truth.rotation()).degrees(), 0.05);
  }
}

TEST(Inertial, NoiseIsAsStrongAsStated) {
  const auto samples =
      MeasureInertial(AtRest(), {0, 20}, {.accelerometer_bias = 0, .gyroscope_bias = 0}, Random(3));
  double force = 0;
  double rate = 0;
  for (const InertialSample& sample : samples) {
    force += (sample.specific_force - Vector3d(0, 0, kGravity)).squaredNorm() / 3;
    rate += sample.angular_velocity.squaredNorm() / 3;
  }
  EXPECT_NEAR(std::sqrt(force / static_cast<double>(samples.size())), 0.05, 0.005);
  EXPECT_NEAR(std::sqrt(rate / static_cast<double>(samples.size())), 0.004, 0.0004);
}

TEST(Satellite, ScattersAroundTheTruthByItsStatedSigma) {
  const TangentPlane plane(GeoPoint{Angle::Degrees(47), Angle::Degrees(8), 400});
  const Motion motion = AtRest();
  for (const SatelliteOptions& options : {CarReceiver(), PhoneReceiver()}) {
    double squares = 0;
    int count = 0;
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
      const auto fixes = MeasureSatellites(motion, {0, 3}, plane, options, Random(seed));
      EXPECT_EQ(fixes.size(), 4U);
      const Vector3d error = plane.ToMap(fixes.back().place).coordinates() - Vector3d(3, 4, 5);
      squares += error.head<2>().squaredNorm();
      count += 2;
    }
    const double sigma_m = std::sqrt(squares / count);
    EXPECT_GT(sigma_m, 0.5 * options.reported_sigma_m);
    EXPECT_LT(sigma_m, 1.2 * options.reported_sigma_m);
  }
}

TEST(Odometry, WithoutErrorsIsTheMotionInAnotherFrame) {
  const Travel walk = TestWalk(2);
  const OdometryOptions perfect{
      .yaw_walk_rad_per_sqrt_s = 0, .scale_sigma = 0, .step_noise_m_per_sqrt_m = 0, .tilt_rad = 0};
  const auto samples = SimulateOdometry(walk.motion, {0, 10}, perfect, Random(5));
  const Rigid3 vo_from_world =
      samples.front().vo_from_device.rigid() * walk.motion.WorldFromBody(0).Inverse();
  EXPECT_GT((vo_from_world.rotation() * Vector3d::UnitZ()).z(), 1 - 1e-12) << "z is up";
  for (const OdometrySample& sample : samples) {
    const Rigid3 expected = vo_from_world * walk.motion.WorldFromBody(sample.time_s);
    EXPECT_LT((sample.vo_from_device.translation() - expected.translation()).norm(), 1e-9);
    EXPECT_LT(AngleBetween(sample.vo_from_device.rotation(), expected.rotation()).radians(), 1e-7);
  }
}

TEST(Odometry, DriftsAsStated) {
  const OdometryOptions options;
  double yaw_squares = 0;
  double position_squares = 0;
  constexpr int kWalks = 100;
  double duration_s = 0;
  for (std::uint64_t seed = 0; seed < kWalks; ++seed) {
    const Travel walk = TestWalk(7);
    const auto samples = SimulateOdometry(walk.motion, {0, walk.duration_s}, options, Random(seed));
    const Rigid3 end =
        walk.motion.WorldFromBody(0).Inverse() * walk.motion.WorldFromBody(samples.back().time_s);
    const Rigid3 vo_end =
        samples.front().vo_from_device.rigid().Inverse() * samples.back().vo_from_device.rigid();
    duration_s = samples.back().time_s;
    const double angle = AngleBetween(end.rotation(), vo_end.rotation()).radians();
    yaw_squares += angle * angle;
    position_squares += (end.translation() - vo_end.translation()).squaredNorm();
  }
  // Heading: random walk plus two independent tilts of two axes at both ends.
  const double expected =
      std::hypot(options.yaw_walk_rad_per_sqrt_s * std::sqrt(duration_s), 2 * options.tilt_rad);
  EXPECT_NEAR(std::sqrt(yaw_squares / kWalks), expected, 0.3 * expected);
  // Position: 1 % of a chord of some 35 m, plus heading, steps and tilt: well under a metre.
  EXPECT_GT(std::sqrt(position_squares / kWalks), 0.2);
  EXPECT_LT(std::sqrt(position_squares / kWalks), 0.8);
}

TEST(Rig, CamerasLookWhereTheirNamesSay) {
  const auto rig = *MakeCarRig(4, {});
  const std::vector<Vector3d> directions{{1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {-1, 0, 0}};
  for (std::size_t i = 0; i < rig.size(); ++i) {
    const Vector3d forward = rig[i].body_from_camera.rotation() * Vector3d::UnitZ();
    const Vector3d down = rig[i].body_from_camera.rotation() * Vector3d::UnitY();
    EXPECT_GT(forward.dot(directions[i]), 0.99) << rig[i].id;
    EXPECT_LT(down.z(), -0.99) << rig[i].id;
  }
  EXPECT_FALSE(MakeCarRig(5, {}).ok());
  EXPECT_FALSE(MakeCarRig(2, {.width_px = 3}).ok());
}

}  // namespace
}  // namespace waymark::simulator
