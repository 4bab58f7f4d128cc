// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/burst/pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "localiser/internal/burst/evidence.h"
#include "localiser/internal/burst/refinement.h"
#include "mapping/estimation/upright_rig.h"
#include "mapping/io/tum_trajectory.h"
#include "tests/localiser/random_place.h"

namespace waymark::localiser::internal {
namespace {

using mapping::ParseTumTrajectory;
using mapping::Ray;
using mapping::SolveUprightRig;

TEST(UprightRig, HasTheTruePoseAmongItsTwo) {
  support::RandomGeometry random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Rigid3 truth(RotationFromVector({0, 0, random.Uniform(-3, 3)}),
                       {random.Uniform(-50, 50), random.Uniform(-50, 50), random.Uniform(-2, 2)});
    std::array<Ray, 2> rays;
    std::array<Eigen::Vector3d, 2> points;
    for (std::size_t i = 0; i < 2; ++i) {
      const Eigen::Vector3d seen(random.Uniform(-9, 9), random.Uniform(5, 20),
                                 random.Uniform(-1, 6));
      rays[i].origin = {random.Uniform(-2, 2), random.Uniform(-2, 2), random.Uniform(0, 1)};
      rays[i].bearing = (seen - rays[i].origin).normalized();
      points[i] = truth * seen;
    }
    std::vector<Rigid3> poses;
    SolveUprightRig(rays, points, poses);
    ASSERT_THAT(poses.size(), testing::AllOf(testing::Ge(1U), testing::Le(2U)));
    double least = 1e9;
    for (const Rigid3& pose : poses) least = std::min(least, Difference(truth, pose).norm());
    EXPECT_LT(least, 1e-6);
  }
}

TEST(UprightRig, HasNoneForPointsAboveEachOtherOrLevelRays) {
  std::vector<Rigid3> poses;
  const Ray ahead{{0, 0, 0}, Eigen::Vector3d(0, 1, 0.2).normalized()};
  const Ray level{{1, 0, 0}, {0, 1, 0}};
  SolveUprightRig({ahead, ahead}, {Eigen::Vector3d(0, 9, 1), Eigen::Vector3d(0, 9, 2)}, poses);
  SolveUprightRig({level, level}, {Eigen::Vector3d(0, 9, 0), Eigen::Vector3d(1, 9, 0)}, poses);
  EXPECT_TRUE(poses.empty());
}

/// Three cameras on a stick before a front, and what each sees of it.
class BurstPose : public testing::Test {
 protected:
  BurstPose() {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const Rigid3 vo_from_camera = place_.Viewpoint(0.7 * k - 1.4, 0.1 * k);
      cameras_.push_back({TestCamera(), vo_from_camera});
      for (std::uint32_t i = 0; i < place_.landmarks().size(); ++i) {
        const Eigen::Vector3d& landmark = place_.landmarks()[i];
        const auto pixel_px =
            TestCamera().Project((truth_ * vo_from_camera).Inverse() * (truth_ * landmark));
        if (!pixel_px || !TestCamera().Contains(*pixel_px)) continue;
        matches_.pixels_px.push_back(*pixel_px);
        matches_.points_in_submap.push_back(truth_ * landmark);
        matches_.quality.push_back(0.5);
        matches_.landmarks.push_back(i);
        matches_.images.push_back(k);
      }
    }
  }

  RandomPlace place_{1};
  Rigid3 truth_{RotationFromVector({0, 0, 1.1}), {40, -20, 3}};
  std::vector<BurstCamera> cameras_;
  ImageMatches matches_;
};

TEST_F(BurstPose, IsExactForExactMatches) {
  const auto pose = EstimateBurstPose(cameras_, matches_, {});
  ASSERT_TRUE(pose.has_value());
  EXPECT_EQ(pose->inliers.size(), matches_.size());
  EXPECT_LT(Difference(truth_, pose->world_from_camera).norm(), 1e-6);
  EXPECT_EQ(pose->focal_factor, 1);
}

TEST_F(BurstPose, OutvotesWrongMatches) {
  support::RandomGeometry random(2);
  std::size_t right = 0;
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    if (i % 8 == 0) {
      ++right;
    } else {
      matches_.points_in_submap[i] += Eigen::Vector3d(random.Uniform(2, 20), 0, 0);
    }
  }
  const auto pose = EstimateBurstPose(cameras_, matches_, {});
  ASSERT_TRUE(pose.has_value());
  EXPECT_GE(pose->inliers.size(), right);
  EXPECT_LT((pose->world_from_camera.translation() - truth_.translation()).norm(), 0.2);
}

TEST_F(BurstPose, OfAnImageMovesWithItsLeverArm) {
  const auto pose = EstimateBurstPose(cameras_, matches_, {});
  ASSERT_TRUE(pose.has_value());
  const auto of_last = PoseOfImage(*pose, cameras_, matches_, 2, 0);
  EXPECT_LT(Difference(truth_ * cameras_[2].vo_from_camera, of_last.world_from_camera).norm(),
            1e-6);
  // The covariance of a function of the pose, by differences.
  Eigen::Matrix<double, 6, 6> jacobian;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Matrix<double, 6, 1> step = 1e-6 * Eigen::Matrix<double, 6, 1>::Unit(i);
    jacobian.col(i) = Difference(of_last.world_from_camera, Perturb(pose->world_from_camera, step) *
                                                                cameras_[2].vo_from_camera) /
                      1e-6;
  }
  const Eigen::Matrix<double, 6, 6> expected = jacobian * pose->covariance * jacobian.transpose();
  EXPECT_LT((of_last.covariance - expected).norm(), 1e-4 * expected.norm());
  const auto drifting = PoseOfImage(*pose, cameras_, matches_, 2, 0.02);
  EXPECT_GT(drifting.covariance(0, 0), of_last.covariance(0, 0) + std::pow(0.02 * 0.3, 2));
}

TEST_F(BurstPose, KnowsThatOdometrysMetreIsWrong) {
  for (BurstCamera& taken : cameras_) {
    taken.vo_from_camera =
        Rigid3(taken.vo_from_camera.rotation(), 1.19 * taken.vo_from_camera.translation());
  }
  const auto pose = EstimateBurstPose(cameras_, matches_, {});
  ASSERT_TRUE(pose.has_value());
  EXPECT_NEAR(pose->odometry_scale, 1 / 1.19, 0.02);
  EXPECT_THAT(FindScaleContradiction(40, pose->odometry_scale),
              testing::Optional(testing::HasSubstr("0.84 times")));
  EXPECT_EQ(FindScaleContradiction(40, 0.9), std::nullopt);
}

TEST_F(BurstPose, EvidenceCountsLandmarksNotSightings) {
  const auto pose = EstimateBurstPose(cameras_, matches_, {});
  ASSERT_TRUE(pose.has_value());
  const auto of_last = PoseOfImage(*pose, cameras_, matches_, 2, 0);
  const BurstEvidence evidence = CountEvidence(matches_, of_last);
  EXPECT_EQ(evidence.images, 3U);
  EXPECT_LT(evidence.landmarks(), matches_.size() / 2);
  EXPECT_NEAR(evidence.median_distance, 14, 4);
  EXPECT_EQ(FindReasonToRefuseBurst(cameras_, matches_, of_last, evidence, 15, 6), std::nullopt);
  EXPECT_THAT(*FindReasonToRefuseBurst(cameras_, matches_, of_last, evidence, 10000, 6),
              testing::HasSubstr("landmarks"));
}

TEST_F(BurstPose, IsNoneWithoutEnoughMatches) {
  EXPECT_EQ(EstimateBurstPose(cameras_, {}, {}), std::nullopt);
  EXPECT_EQ(
      EstimateBurstPose(cameras_, matches_, {.min_inliers = static_cast<int>(matches_.size()) + 1}),
      std::nullopt);
}

TEST_F(BurstPose, IsNoneForMatchesBehindTheCameras) {
  for (Eigen::Vector3d& point : matches_.points_in_submap) {
    point = truth_ * Eigen::Vector3d(0, -5, 1);  // one place, seen everywhere
  }
  EXPECT_EQ(EstimateBurstPose(cameras_, matches_, {}), std::nullopt);
}

TEST(BurstOdometry, ReadsTumAndNamesWhatItCannotRead) {
  const auto poses =
      ParseTumTrajectory("# comment\n\n1.50 1 2 3 0 0 0 1\nb.jpg 4 5 6 0 0 1 0\n", "odom");
  ASSERT_TRUE(poses.ok()) << ToString(poses.error());
  EXPECT_EQ(poses->size(), 2U);
  EXPECT_EQ(poses->at("1.50").translation(), Eigen::Vector3d(1, 2, 3));
  for (const char* text : {"a 1 2 3 0 0 0\n", "a 1 2 3 0 0 0 2\n", "a nan 2 3 0 0 0 1\n",
                           "a 1 2 3 nan 0 0 1\n", "a b c d e f g h\n"}) {
    const auto refused = ParseTumTrajectory(text, "odom");
    ASSERT_FALSE(refused.ok()) << text;
    EXPECT_THAT(refused.error().message, testing::HasSubstr("odom:1"));
  }
}

}  // namespace
}  // namespace waymark::localiser::internal
