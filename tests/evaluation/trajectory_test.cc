// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/random_geometry.h"

namespace waymark::evaluation {
namespace {

using support::RandomGeometry;

/// A path with a sideways extent in metres; 0 is a straight line.
Trajectory MakePath(double sideways_m, std::uint64_t seed) {
  RandomGeometry random(seed);
  Trajectory path;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d position(2 * i, random.Uniform(-1, 1) * sideways_m,
                                   random.Uniform(-1, 1) * sideways_m);
    path["image" + std::to_string(100 + i)] =
        Rigid3(RotationFromVector({0.02 * i, -1.2, 0.3}), position);
  }
  return path;
}

Trajectory Carry(const Sim3& b_from_a, const Trajectory& path) {
  Trajectory carried;
  for (const auto& [name, pose] : path) carried[name] = CarryPose(b_from_a, pose);
  return carried;
}

TEST(EstimateAlignment, UndoesASimilarity) {
  RandomGeometry random(1);
  for (int i = 0; i < 20; ++i) {
    const Trajectory truth = MakePath(5, i);
    const Sim3 similarity = random.Similarity();
    const auto alignment = EstimateAlignment(Carry(similarity, truth), truth);
    ASSERT_TRUE(alignment.ok());
    const TrajectoryErrors errors = ComputeErrors(Carry(similarity, truth), truth, *alignment);
    EXPECT_EQ(errors.common, 30u);
    EXPECT_LT(errors.max_m, 1e-9);
    EXPECT_LT(errors.median_rotation_rad, 1e-7);
  }
}

TEST(EstimateAlignment, OrientationsSettleTheTurnAboutAStraightPath) {
  RandomGeometry random(2);
  const Trajectory truth = MakePath(0, 1);
  const Sim3 similarity = random.Similarity();
  const auto alignment = EstimateAlignment(Carry(similarity, truth), truth);
  ASSERT_TRUE(alignment.ok());
  const TrajectoryErrors errors = ComputeErrors(Carry(similarity, truth), truth, *alignment);
  EXPECT_LT(errors.max_m, 1e-9);
  EXPECT_LT(errors.median_rotation_rad, 1e-7);
}

TEST(EstimateAlignment, HardlyDiffersFromPositionsAloneWhereTheyDecide) {
  RandomGeometry random(3);
  const Trajectory truth = MakePath(8, 1);
  Trajectory noisy;
  std::vector<Eigen::Vector3d> from, to;
  for (const auto& [name, pose] : truth) {
    noisy[name] = Rigid3(RotationFromVector(random.Vector(0.05)) * pose.rotation(),
                         pose.translation() + random.Vector(0.1));
    from.push_back(noisy[name].translation());
    to.push_back(pose.translation());
  }
  const double ours = ComputeErrors(noisy, truth, *EstimateAlignment(noisy, truth)).rmse_m;
  const double best = ComputeErrors(noisy, truth, *EstimateSimilarity(from, to)).rmse_m;
  EXPECT_GE(ours, best);
  EXPECT_LT(ours, 1.01 * best);
}

TEST(EstimateAlignment, NeedsTwoPlaces) {
  Trajectory one;
  one["a"] = Rigid3();
  EXPECT_FALSE(EstimateAlignment(one, one).ok());
  one["b"] = Rigid3();
  EXPECT_FALSE(EstimateAlignment(one, one).ok());
}

TEST(ComputeErrors, GivesTheFiguresOfKnownErrors) {
  const Trajectory truth = MakePath(0, 1);
  Trajectory estimate = truth;
  int i = 0;
  for (auto& [name, pose] : estimate) {
    pose = Rigid3(pose.rotation(), pose.translation() + Eigen::Vector3d(0, i++ == 0 ? 30 : 3, 0));
  }
  const TrajectoryErrors errors = ComputeErrors(estimate, truth, Sim3());
  EXPECT_NEAR(errors.mean_m, 3.9, 1e-12);
  EXPECT_NEAR(errors.median_m, 3, 1e-12);
  EXPECT_NEAR(errors.max_m, 30, 1e-12);
  EXPECT_NEAR(errors.rmse_m, std::sqrt((900 + 29 * 9) / 30.0), 1e-12);
  EXPECT_NEAR(errors.path_m, 58, 1e-12);
}

TEST(TumTrajectory, ReadsCommentsAndRefusesBrokenLinesByNumber) {
  const auto good = ParseTumTrajectory("# poses\n\na.jpg 1 2 3 0 0 0 1\r\n", "t");
  ASSERT_TRUE(good.ok());
  EXPECT_EQ(good->at("a.jpg").translation(), Eigen::Vector3d(1, 2, 3));
  for (const char* text : {"a.jpg 1 2 3 0 0 0\n", "a.jpg 1 2 x 0 0 0 1\n", "a 1 2 3 0 0 0 2\n"}) {
    const auto broken = ParseTumTrajectory(text, "t");
    ASSERT_FALSE(broken.ok()) << text;
    EXPECT_THAT(broken.error().message, testing::HasSubstr("t:1"));
  }
}

}  // namespace
}  // namespace waymark::evaluation
