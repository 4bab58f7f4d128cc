// SPDX-License-Identifier: Apache-2.0
#include "localiser/odometry_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <cmath>
#include <limits>

#include "tests/localiser/simulated_walk.h"

namespace waymark::localiser {
namespace {

constexpr WalkNoise kPhone{
    .drift_share = 0.01, .yaw_drift_rad_m = 0.0005, .fix_sigma_m = 0.1, .fix_sigma_rad = 0.01};

TEST(OdometryAlignment, KnowsNothingBeforeTheFirstFix) {
  const OdometryAlignment alignment({});
  const Alignment answer = alignment.Estimate(FromNanoseconds<DeviceTime>(5));
  EXPECT_EQ(answer.state, AlignmentState::kNever);
  EXPECT_FALSE(answer.map_from_vo.has_value());
}

TEST(OdometryAlignment, OneExactFixGivesTheWholeAlignmentButOnlyCoarsely) {
  SimulatedWalk walk({}, 1);
  OdometryAlignment alignment({});
  alignment.AddFix(walk.Fix(10));
  const Alignment answer = alignment.Estimate(walk.Time(10));
  EXPECT_EQ(answer.state, AlignmentState::kCoarse);
  EXPECT_EQ(answer.supporting_fixes, 1);
  ASSERT_TRUE(answer.map_from_vo.has_value());
  EXPECT_LT(walk.PositionError(answer, 10), 1e-6);
  EXPECT_LT(walk.PositionError(answer, 40), 1e-4) << "yaw comes from the fix's own rotation";
}

TEST(OdometryAlignment, ExactFixesAreReproducedExactly) {
  SimulatedWalk walk({}, 1);
  OdometryAlignment alignment({});
  for (int i = 0; i < 10; ++i) alignment.AddFix(walk.Fix(i));
  const Alignment answer = alignment.Estimate(walk.Time(10));
  EXPECT_EQ(answer.state, AlignmentState::kFixed);
  EXPECT_EQ(answer.supporting_fixes, 10);
  EXPECT_LT(walk.PositionError(answer, 10), 1e-6);
}

TEST(OdometryAlignment, FollowsTheDriftThatOneRigidAlignmentCannot) {
  WalkNoise noise = kPhone;
  noise.drift_share = 0.03;
  SimulatedWalk walk(noise, 2);
  OdometryAlignment decaying({});
  OdometryAlignment rigid({.half_life = std::chrono::hours(10), .max_fixes = 1000});
  double decaying_error_m = 0;
  double rigid_error_m = 0;
  for (int i = 0; i < 240; ++i) {
    const MapFix fix = walk.Fix(i);
    decaying.AddFix(fix);
    rigid.AddFix(fix);
    if (i < 120 || i % 20 != 0) continue;
    decaying_error_m += walk.PositionError(decaying.Estimate(walk.Time(i)), i) / 6;
    rigid_error_m += walk.PositionError(rigid.Estimate(walk.Time(i)), i) / 6;
  }
  EXPECT_LT(decaying_error_m, 0.5);
  EXPECT_GT(rigid_error_m, 2 * decaying_error_m);
}

TEST(OdometryAlignment, WhoWalksTrustsWhatIsNewAndVotesDoNotFade) {
  WalkNoise noise = kPhone;
  noise.drift_share = 0.03;
  noise.fix_sigma_m = 0.02;
  SimulatedWalk walk(noise, 4);
  OdometryAlignment fading({});
  OdometryAlignment even({.drift_share = 0});
  double fading_error_m = 0, even_error_m = 0;
  for (int i = 0; i < 120; ++i) {
    const MapFix fix = walk.Fix(i);
    fading.AddFix(fix);
    even.AddFix(fix);
    if (i < 40) continue;
    const Alignment answer = fading.Estimate(walk.Time(i));
    EXPECT_EQ(answer.contradicting_fixes, even.Estimate(walk.Time(i)).contradicting_fixes);
    fading_error_m += walk.PositionError(answer, i) / 80;
    even_error_m += walk.PositionError(even.Estimate(walk.Time(i)), i) / 80;
  }
  EXPECT_LT(fading_error_m, 0.7 * even_error_m) << fading_error_m << " against " << even_error_m;
}

TEST(OdometryAlignment, GrossErrorsHaveNoSay) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SimulatedWalk walk(kPhone, seed);
    OdometryAlignment alignment({});
    for (int i = 0; i < 40; ++i) alignment.AddFix(i % 3 == 0 ? walk.FalseFix(i) : walk.Fix(i));
    const Alignment answer = alignment.Estimate(walk.Time(40));
    EXPECT_EQ(answer.state, AlignmentState::kFixed) << "seed " << seed;
    EXPECT_LT(walk.PositionError(answer, 40), 0.4) << "seed " << seed;
    EXPECT_GE(answer.contradicting_fixes, 8) << "seed " << seed;
  }
}

TEST(OdometryAlignment, FixesThatAllDisagreeAreNeverCalledFixed) {
  SimulatedWalk walk(kPhone, 3);
  OdometryAlignment alignment({});
  for (int i = 0; i < 20; ++i) alignment.AddFix(walk.FalseFix(i));
  EXPECT_EQ(alignment.Estimate(walk.Time(20)).state, AlignmentState::kCoarse);
}

TEST(OdometryAlignment, AFixThatContradictsGravityIsNoEvidence) {
  SimulatedWalk walk({}, 3);
  OdometryAlignment alignment({});
  for (int i = 0; i < 4; ++i) alignment.AddFix(walk.Fix(i));
  Eigen::Matrix<double, 6, 1> tilt = Eigen::Matrix<double, 6, 1>::Zero();
  tilt(3) = 0.6;
  alignment.AddFix(walk.FixAt(4, Perturb(walk.MapFromDevice(4).rigid(), tilt)));
  const Alignment answer = alignment.Estimate(walk.Time(5));
  EXPECT_EQ(answer.supporting_fixes, 4);
  EXPECT_EQ(answer.contradicting_fixes, 1);
  EXPECT_LT(walk.PositionError(answer, 5), 1e-6);
}

TEST(OdometryAlignment, AStationaryPhoneGetsItsYawFromRotations) {
  SimulatedWalk walk(kPhone, 4);
  OdometryAlignment alignment({});
  for (int i = 0; i < 30; ++i) {
    MapFix fix = walk.Fix(7);
    fix.time = walk.Time(i);
    alignment.AddFix(fix);
  }
  const Alignment answer = alignment.Estimate(walk.Time(30));
  EXPECT_EQ(answer.state, AlignmentState::kFixed);
  EXPECT_LT(walk.PositionError(answer, 7), 0.1);
  const Rigid3 truth = walk.MapFromDevice(7).rigid() * walk.VoFromDevice(7).rigid().Inverse();
  EXPECT_LT(AngleBetween(answer.map_from_vo->rotation(), truth.rotation()).degrees(), 0.5);
}

TEST(OdometryAlignment, KeepsBothFramesUprightUnlessAskedForAllSixFreedoms) {
  WalkNoise noise = kPhone;
  noise.fix_sigma_rad = 0.03;
  SimulatedWalk walk(noise, 5);
  OdometryAlignment upright({});
  OdometryAlignment full({.freedom = AlignmentFreedom::kFull});
  for (int i = 0; i < 20; ++i) {
    const MapFix fix = walk.Fix(i);
    upright.AddFix(fix);
    full.AddFix(fix);
  }
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const auto tilt = [&](const OdometryAlignment& alignment) {
    return (alignment.Estimate(walk.Time(20)).map_from_vo->rotation() * up - up).norm();
  };
  EXPECT_LT(tilt(upright), 1e-12);
  EXPECT_GT(tilt(full), 1e-6);
  EXPECT_LT(walk.PositionError(full.Estimate(walk.Time(20)), 20), 0.4);
}

TEST(OdometryAlignment, AnUncertainFixWeighsLess) {
  SimulatedWalk walk({}, 6);
  MapFix good = walk.Fix(0);
  good.covariance *= 0.01;
  MapFix poor = walk.Fix(0.1);
  poor.map_from_device =
      Transform<Map, Device>(poor.map_from_device.rotation(),
                             poor.map_from_device.translation() + Eigen::Vector3d(0, 0, 0.4));
  poor.covariance = Eigen::Matrix<double, 6, 6>::Identity();
  OdometryAlignment alignment({});
  alignment.AddFix(good);
  alignment.AddFix(poor);
  EXPECT_LT(walk.PositionError(alignment.Estimate(walk.Time(0.1)), 0), 0.02);
}

TEST(OdometryAlignment, CovarianceCoversTheErrorAndGrowsWithAge) {
  int covered = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SimulatedWalk walk({.fix_sigma_m = 0.1, .fix_sigma_rad = 0.0175}, seed);
    OdometryAlignment alignment({});
    for (int i = 0; i < 15; ++i) alignment.AddFix(walk.Fix(i));
    const Alignment answer = alignment.Estimate(walk.Time(15));
    const Rigid3 truth = walk.MapFromDevice(9).rigid() * walk.VoFromDevice(9).rigid().Inverse();
    const Eigen::Matrix<double, 6, 1> error = Difference(answer.map_from_vo->rigid(), truth);
    const Eigen::Matrix4d information =
        answer.covariance(std::vector{0, 1, 2, 5}, std::vector{0, 1, 2, 5}).inverse();
    const Eigen::Vector4d known = error(std::vector{0, 1, 2, 5});
    covered += known.dot(information * known) < 13.3;  // 99 % of chi squared, 4 degrees of freedom
    const Alignment later = alignment.Estimate(walk.Time(60));
    EXPECT_GT(later.covariance(0, 0), answer.covariance(0, 0));
  }
  EXPECT_GE(covered, 47);
}

double TiltSigma(const Alignment& answer) {
  return std::sqrt(answer.covariance.block<2, 2>(3, 3).trace() / 2);
}

TEST(OdometryAlignment, ManyFixesTellTheTiltAndNoneTellsTheMapsOwnError) {
  SimulatedWalk walk({}, 1);
  OdometryAlignment alignment({});
  alignment.AddFix(walk.Fix(0));
  const double tilt_of_one = TiltSigma(alignment.Estimate(walk.Time(0)));
  for (int i = 1; i < 32; ++i) alignment.AddFix(walk.Fix(i));
  const Alignment answer = alignment.Estimate(walk.Time(31));
  EXPECT_LT(TiltSigma(answer), 0.8 * tilt_of_one);
  const Eigen::Vector3d lever =
      answer.map_from_vo->rotation() * walk.VoFromDevice(31).translation();
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << Eigen::Matrix3d::Identity(), -CrossMatrix(lever);
  const Eigen::Matrix3d position = jacobian * answer.covariance * jacobian.transpose();
  const double floor_m = AlignmentOptions{}.sigma_floor_m;
  EXPECT_GT(position.eigenvalues().real().minCoeff(), floor_m * floor_m);
}

TEST(OdometryAlignment, StaysUprightWhereFixesLeanAndSaysSo) {
  constexpr double kLean = 0.03;
  SimulatedWalk walk({}, 1);
  OdometryAlignment alignment({});
  for (int i = 0; i < 20; ++i) {
    const Rigid3 truth = walk.MapFromDevice(i).rigid();
    const Eigen::Quaterniond leaning = RotationFromVector({kLean, 0, 0}) * truth.rotation();
    alignment.AddFix(walk.FixAt(i, {leaning, truth.translation()}));
  }
  const Alignment answer = alignment.Estimate(walk.Time(20));
  const Eigen::Vector3d up = answer.map_from_vo->rotation() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(up.z(), 1, 1e-9);
  EXPECT_GT(std::sqrt(answer.covariance(3, 3)), kLean / 3);
  EXPECT_GT(answer.covariance(3, 3), 3 * answer.covariance(4, 4));
}

TEST(OdometryAlignment, GoesStaleWhenNoFixArrivesAndRecoversWithNewOnes) {
  SimulatedWalk walk(kPhone, 7);
  OdometryAlignment alignment({});
  for (int i = 0; i < 5; ++i) alignment.AddFix(walk.Fix(i));
  EXPECT_EQ(alignment.Estimate(walk.Time(30)).state, AlignmentState::kFixed);
  const Alignment stale = alignment.Estimate(walk.Time(40));
  EXPECT_EQ(stale.state, AlignmentState::kStale);
  EXPECT_TRUE(stale.map_from_vo.has_value());
  for (int i = 40; i < 44; ++i) alignment.AddFix(walk.Fix(i));
  EXPECT_EQ(alignment.Estimate(walk.Time(44)).state, AlignmentState::kFixed);
}

TEST(OdometryAlignment, ResetForgetsEverything) {
  SimulatedWalk walk(kPhone, 8);
  OdometryAlignment alignment({});
  for (int i = 0; i < 5; ++i) alignment.AddFix(walk.Fix(i));
  alignment.ResetOdometry();
  EXPECT_EQ(alignment.Estimate(walk.Time(5)).state, AlignmentState::kNever);
}

TEST(OdometryAlignment, AnUnannouncedResetIsOutvotedByTheNewFixes) {
  SimulatedWalk walk(kPhone, 9);
  OdometryAlignment alignment({});
  for (int i = 0; i < 10; ++i) alignment.AddFix(walk.Fix(i));
  const Rigid3 jump(RotationFromVector({0, 0, 1}), Eigen::Vector3d(30, 5, 0));
  for (int i = 10; i < 30; ++i) {
    MapFix fix = walk.Fix(i);
    fix.vo_from_device = Transform<Vo, Device>(jump * fix.vo_from_device.rigid());
    alignment.AddFix(fix);
  }
  const Alignment answer = alignment.Estimate(walk.Time(30));
  EXPECT_EQ(answer.state, AlignmentState::kFixed);
  EXPECT_EQ(answer.contradicting_fixes, 10);
}

TEST(OdometryAlignment, AnswersMayArriveOutOfOrderAndTwice) {
  SimulatedWalk walk(kPhone, 10);
  std::vector<MapFix> fixes;
  for (int i = 0; i < 8; ++i) fixes.push_back(walk.Fix(i));
  OdometryAlignment sorted({});
  OdometryAlignment shuffled({});
  for (const MapFix& fix : fixes) sorted.AddFix(fix);
  for (const int i : {3, 0, 7, 3, 1, 6, 2, 5, 4, 0}) shuffled.AddFix(fixes[i]);
  EXPECT_EQ(shuffled.fixes().size(), 8u);
  EXPECT_EQ(sorted.Estimate(walk.Time(9)).map_from_vo->translation(),
            shuffled.Estimate(walk.Time(9)).map_from_vo->translation());
}

TEST(OdometryAlignment, AClockSetBackStartsAnew) {
  SimulatedWalk walk(kPhone, 11);
  OdometryAlignment alignment({});
  MapFix from_the_future = walk.Fix(0);
  from_the_future.time = DeviceTime::max();
  alignment.AddFix(from_the_future);
  for (int i = 0; i < 5; ++i) alignment.AddFix(walk.Fix(i));
  EXPECT_EQ(alignment.fixes().size(), 5u);
  EXPECT_EQ(alignment.Estimate(walk.Time(5)).state, AlignmentState::kFixed);
  EXPECT_EQ(alignment.Estimate(DeviceTime::min()).state, AlignmentState::kStale);
  EXPECT_TRUE(alignment.Estimate(DeviceTime::max()).map_from_vo->translation().allFinite());
}

TEST(OdometryAlignment, MemoryStaysBoundedAndNumbersFinite) {
  SimulatedWalk walk(kPhone, 12);
  OdometryAlignment alignment({.max_fixes = 16});
  for (int i = 0; i < 1000; ++i) alignment.AddFix(walk.Fix(i));
  EXPECT_EQ(alignment.fixes().size(), 16u);
  MapFix broken = walk.Fix(1001);
  broken.covariance(2, 2) = std::numeric_limits<double>::quiet_NaN();
  alignment.AddFix(broken);
  EXPECT_EQ(alignment.fixes().back().time, walk.Time(999));
}

TEST(AlignmentOptions, NonsenseIsRefusedByName) {
  EXPECT_TRUE(AlignmentOptions{}.Validate().ok());
  const Result<void> refused = AlignmentOptions{.huber_m = 0}.Validate();
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message, testing::HasSubstr("huber_m"));
  EXPECT_FALSE(AlignmentOptions{.max_fixes = 0}.Validate().ok());
}

}  // namespace
}  // namespace waymark::localiser
