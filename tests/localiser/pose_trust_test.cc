// SPDX-License-Identifier: Apache-2.0
// When an image fits two places, and how sure a pose may claim to be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "localiser/internal/look_alike.h"
#include "localiser/internal/pose_acceptance.h"
#include "localiser/internal/stated_covariance.h"
#include "tests/localiser/random_place.h"

namespace waymark::localiser::internal {
namespace {

constexpr double kMaxErrorPx = 6;

/// Landmarks that a viewpoint sees; those from `first_copied` on are believed to be elsewhere.
ImageMatches MatchPlace(const RandomPlace& place, const Rigid3& viewpoint, std::size_t count,
                        std::size_t first_copied, const Eigen::Vector3d& copy_offset) {
  ImageMatches matches;
  for (const Eigen::Vector3d& landmark : place.landmarks()) {
    const auto pixel_px = TestCamera().Project(viewpoint.Inverse() * landmark);
    if (!pixel_px || !TestCamera().Contains(*pixel_px)) continue;
    const bool is_copied = matches.points_in_submap.size() >= first_copied;
    matches.pixels_px.push_back(*pixel_px);
    matches.points_in_submap.push_back(is_copied ? Eigen::Vector3d(landmark + copy_offset)
                                                 : landmark);
    matches.quality.push_back(0.5);
    matches.landmarks.push_back(static_cast<std::uint32_t>(matches.landmarks.size()));
    if (matches.points_in_submap.size() == count) break;
  }
  return matches;
}

std::optional<LookAlike> FindIn(const ImageMatches& matches,
                                const std::optional<mapping::SharedUp>& up = std::nullopt) {
  const auto pose =
      mapping::EstimateAbsolutePose(TestCamera(), matches.pixels_px, matches.points_in_submap, {},
                                    {.max_error_px = kMaxErrorPx, .min_inliers = 15});
  CHECK(pose.ok() && *pose, "the first pose");
  return *FindLookAlike({TestCamera(), up}, matches, **pose, 12, kMaxErrorPx);
}

TEST(LookAlike, IsFoundWhereMatchesAreSharedBetweenTwoHousesOfOneKind) {
  const RandomPlace place(1);
  const ImageMatches matches = MatchPlace(place, place.Viewpoint(0), 90, 60, {9.5, 0, 0});
  const auto found = FindIn(matches);
  ASSERT_TRUE(found.has_value());
  EXPECT_GE(found->agreeing, 28U);
  EXPECT_EQ(found->matches, 30U);
  EXPECT_NEAR(found->distance_m, 9.5, 0.1);
  const auto up_in_camera = place.Viewpoint(0).rotation().conjugate() * Eigen::Vector3d::UnitZ();
  const auto with_gravity =
      FindIn(matches, mapping::SharedUp{up_in_camera, Eigen::Vector3d::UnitZ()});
  ASSERT_TRUE(with_gravity.has_value());
  EXPECT_EQ(with_gravity->agreeing, found->agreeing);
}

TEST(LookAlike, IsNotSeenInAFewMatchesOnTheNextRowOfWindows) {
  const RandomPlace place({.landmarks = 1200}, 1);
  const auto with_copies_at = [&](double offset_m, std::size_t copies) {
    return FindIn(MatchPlace(place, place.Viewpoint(0), 120 + copies, 120, {offset_m, 0, 0}));
  };
  EXPECT_FALSE(with_copies_at(2.5, 15).has_value());
  EXPECT_TRUE(with_copies_at(9.5, 15).has_value()) << "a house away";
  EXPECT_TRUE(with_copies_at(2.5, 40).has_value()) << "too many for windows";
}

TEST(LookAlike, IsNotSeenInMatchesThatAgreeOnNothing) {
  const RandomPlace place(1);
  support::RandomGeometry random(2);
  ImageMatches matches = MatchPlace(place, place.Viewpoint(0), 90, 60, {9.5, 0, 0});
  for (std::size_t i = 60; i < matches.points_in_submap.size(); ++i) {
    matches.points_in_submap[i] = {random.Uniform(-15, 15), random.Uniform(10, 16),
                                   random.Uniform(-1, 7)};
  }
  EXPECT_FALSE(FindIn(matches).has_value());
}

TEST(LookAlike, IsNotSeenWhereTheRestAgreesOnTheSamePlace) {
  const RandomPlace place(1);
  const ImageMatches matches = MatchPlace(place, place.Viewpoint(0), 90, 60, {0.25, 0, 0});
  EXPECT_FALSE(FindIn(matches).has_value());
}

Eigen::Matrix<double, 6, 6> Covariance(double sigma_m, Angle sigma) {
  Eigen::Matrix<double, 6, 6> covariance = 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
  covariance(1, 1) = sigma_m * sigma_m;
  covariance(5, 5) = sigma.radians() * sigma.radians();
  return covariance;
}

TEST(Doubt, IsWhatMayBeOffByAMetreOrFiveDegrees) {
  const auto find = [](double sigma_m, double sigma_deg) {
    return FindDoubt(Covariance(sigma_m, Angle::Degrees(sigma_deg)), true);
  };
  EXPECT_EQ(find(0.24, 1.2), std::nullopt);
  EXPECT_THAT(find(0.26, 1.2), testing::Optional(testing::HasSubstr("uncertain by 0.26 m")));
  EXPECT_THAT(find(0.24, 1.3), testing::Optional(testing::HasSubstr("1.30 degrees")));
}

TEST(Doubt, OfMetresNeedsAMapInMetres) {
  EXPECT_EQ(FindDoubt(Covariance(7, Angle::Degrees(1)), false), std::nullopt);
  EXPECT_TRUE(FindDoubt(Covariance(7, Angle::Degrees(2)), false).has_value());
}

// Errors as localisation has them: neighbouring features share theirs, images are shifted.
TEST(StatedCovariance, HoldsErrorsThatAreNotIndependent) {
  const RandomPlace place(3);
  support::RandomGeometry random(4);
  constexpr int kTrials = 300;
  int position = 0, rotation = 0, both = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Rigid3 truth = place.Viewpoint(random.Uniform(-3, 3), random.Uniform(-2, 2));
    ImageMatches matches = MatchPlace(place, truth, 120, 120, Eigen::Vector3d::Zero());
    const Eigen::Vector2d shift_px(random.Normal(0.11), random.Normal(0.11));
    Eigen::Vector2d noise_px = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < matches.points_in_submap.size(); ++i) {
      const bool is_twin = i % 2 == 1;  // of the one before
      if (!is_twin) noise_px = {random.Normal(0.8), random.Normal(0.8)};
      matches.pixels_px[i] += noise_px + shift_px;
    }
    const auto pose =
        mapping::EstimateAbsolutePose(TestCamera(), matches.pixels_px, matches.points_in_submap, {},
                                      {.max_error_px = kMaxErrorPx, .min_inliers = 15});
    ASSERT_TRUE(pose.ok() && *pose);
    const auto covariance = StatedCovariance((*pose)->covariance, TestCamera(), 0);
    const auto error = Difference(truth, (*pose)->world_from_camera);
    const Eigen::Matrix3d of_position = covariance.topLeftCorner<3, 3>();
    const Eigen::Matrix3d of_rotation = covariance.bottomRightCorner<3, 3>();
    const Eigen::Vector3d moved = error.head<3>(), turned = error.tail<3>();
    position += moved.dot(of_position.ldlt().solve(moved)) < 7.815;
    rotation += turned.dot(of_rotation.ldlt().solve(turned)) < 7.815;
    both += error.dot(covariance.ldlt().solve(error)) < 12.592;
  }
  for (const int inside : {position, rotation, both}) {
    EXPECT_GE(inside, 0.9 * kTrials);
  }
}

TEST(StatedCovariance, GrowsWithTheDistanceToWhatIsSeen) {
  const Eigen::Matrix<double, 6, 6> none = Eigen::Matrix<double, 6, 6>::Zero();
  const auto near = StatedCovariance(none, TestCamera(), 10);
  const auto far = StatedCovariance(none, TestCamera(), 20);
  EXPECT_GT(near(0, 0), 0);
  EXPECT_DOUBLE_EQ(far(0, 0), 4 * near(0, 0));
  EXPECT_DOUBLE_EQ(far(3, 3), near(3, 3));
}

}  // namespace
}  // namespace waymark::localiser::internal
