// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/motion/motion.h"

#include <gmock/gmock.h>

#include <cmath>

#include "examples/simulator/motion/travel.h"
#include "tests/examples/simulator/small_world.h"

namespace waymark::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

City EmptyCity() {
  City city{{}, {{{0, 0}, {52, 40}}}, {}, {}, {}, {}};
  return city;
}

TEST(CubicSpline, FollowsAStraightLineExactly) {
  std::vector<Vector3d> controls;
  for (int i = 0; i < 9; ++i) controls.emplace_back(2.0 * i, -1.0 * i, 3);
  const CubicSpline<3> spline(controls, 0.5, -1);
  for (double t = spline.first_s(); t <= spline.last_s(); t += 0.1) {
    const auto sample = spline.At(t);
    EXPECT_LT((sample.value - Vector3d(4 * (t + 1), -2 * (t + 1), 3)).norm(), 1e-12);
    EXPECT_LT((sample.velocity - Vector3d(4, -2, 0)).norm(), 1e-12);
    EXPECT_LT(sample.acceleration.norm(), 1e-12);
  }
}

TEST(CubicSpline, IsTwiceContinuouslyDifferentiable) {
  Random random(4);
  std::vector<Vector3d> controls;
  for (int i = 0; i < 12; ++i) controls.push_back(random.NormalVector(1));
  const CubicSpline<3> spline(controls, 0.25, 0);
  for (int node = 2; node < 9; ++node) {
    const auto before = spline.At(0.25 * node - 1e-9);
    const auto after = spline.At(0.25 * node + 1e-9);
    EXPECT_LT((after.value - before.value).norm(), 1e-6);
    EXPECT_LT((after.velocity - before.velocity).norm(), 1e-6);
    EXPECT_LT((after.acceleration - before.acceleration).norm(), 1e-5);
  }
}

TEST(Route, KeepsItsDistanceAndCloses) {
  const Block block{{0, 0}, {52, 40}};
  for (const Turning turning : {Turning::kCounterClockwise, Turning::kClockwise}) {
    const Route route(block, 7, 5, turning);
    EXPECT_LT((route.At(0) - Vector2d(26, -7)).norm(), 1e-9);
    EXPECT_LT((route.At(route.length_m()) - route.At(0)).norm(), 1e-9);
    for (double s = 0; s < route.length_m(); s += 0.5) {
      EXPECT_NEAR((route.At(s + 1e-4) - route.At(s)).norm(), 1e-4, 1e-8) << s;
      const Vector2d place = route.At(s);
      const Vector2d inside = place.cwiseMax(block.low).cwiseMin(block.high);
      EXPECT_LE((place - inside).cwiseAbs().maxCoeff(), 7 + 1e-9);
      EXPECT_GE((place - inside).norm(), 7 - 1e-9);
    }
  }
}

TEST(Route, TurnsTheWayItSays) {
  const Block block{{0, 0}, {52, 40}};
  EXPECT_GT(Route(block, 7, 5, Turning::kCounterClockwise).At(1).x(), 26);
  EXPECT_LT(Route(block, 7, 5, Turning::kClockwise).At(1).x(), 26);
}

TEST(Route, FindsTheNearestPlace) {
  const Route route({{0, 0}, {52, 40}}, 7, 5, Turning::kClockwise);
  for (const double s : {3.0, 50.0, 111.0}) {
    EXPECT_NEAR(route.FindNearest(route.At(s)), s, 0.11);
  }
}

class TravelTest : public testing::Test {
 protected:
  const City city_ = EmptyCity();
  const Travel drive_ = MakeDrive(city_, {}, Random(1));
  const Travel walk_ = MakeWalk(city_, {}, {}, Pavement::kInner, Turning::kClockwise, Random(2));
};

TEST_F(TravelTest, DerivativesAgreeWithDifferences) {
  constexpr double kStep = 1e-4;
  for (const Travel* travel : {&drive_, &walk_}) {
    const Motion& motion = travel->motion;
    for (double t = 0.05; t < travel->duration_s; t += 0.73) {
      const Vector3d before = motion.WorldFromBody(t - kStep).translation();
      const Vector3d here = motion.WorldFromBody(t).translation();
      const Vector3d after = motion.WorldFromBody(t + kStep).translation();
      EXPECT_LT((motion.VelocityInWorld(t) - (after - before) / (2 * kStep)).norm(), 1e-6);
      EXPECT_LT(
          (motion.AccelerationInWorld(t) - (after - 2 * here + before) / (kStep * kStep)).norm(),
          5e-3);
    }
  }
}

TEST_F(TravelTest, CarLooksWhereItGoes) {
  for (double t = 0; t <= drive_.duration_s; t += 0.5) {
    const Vector3d forward = drive_.motion.WorldFromBody(t).rotation() * Vector3d::UnitX();
    EXPECT_GT(forward.dot(drive_.motion.VelocityInWorld(t).normalized()), 0.9998);
  }
}

TEST_F(TravelTest, WalkerStaysUprightAtEyeHeight) {
  for (double t = 0; t <= walk_.duration_s; t += 0.5) {
    const Rigid3 pose = walk_.motion.WorldFromBody(t);
    EXPECT_NEAR(pose.translation().z(), 1.6 + kKerbHeight, 0.05);
    EXPECT_GT((pose.rotation() * Vector3d::UnitZ()).z(), std::cos(0.35));
  }
}

TEST_F(TravelTest, WalkersStayOnTheirPavement) {
  const Block& block = city_.blocks.front();
  const double street = city_.options.StreetWidth();
  for (const Pavement pavement : {Pavement::kInner, Pavement::kOuter}) {
    const Travel walk = MakeWalk(city_, {}, {}, pavement, Turning::kCounterClockwise, Random(3));
    for (double t = 0; t <= walk.duration_s; t += 0.5) {
      const Vector2d place = walk.motion.WorldFromBody(t).translation().head<2>();
      const Vector2d inside = place.cwiseMax(block.low).cwiseMin(block.high);
      const double distance = (place - inside).cwiseAbs().maxCoeff();
      const double wanted = pavement == Pavement::kInner ? 1.5 : street - 1.5;
      EXPECT_LT(distance, wanted + 0.2);
      if (pavement == Pavement::kInner) {
        EXPECT_GT((place - inside).norm(), 0.9);
      }
    }
  }
}

}  // namespace
}  // namespace waymark::simulator
