// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/two_view.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/support/random_geometry.h"

namespace waymark::mapping {
namespace {

enum class Shape { kVolume, kPlane };

struct Pair {
  CameraModel camera;
  Rigid3 first_from_second;
  std::vector<Eigen::Vector2d> first_px;
  std::vector<Eigen::Vector2d> second_px;
  std::size_t inlier_count;
};

Pair MakePair(std::uint64_t seed, std::size_t count, double inlier_share, double noise_px,
              double baseline, Shape shape = Shape::kVolume) {
  support::RandomGeometry random(seed);
  const std::array parameters{500.0, 320.0, 240.0, -0.05};
  Pair pair{*CameraModel::Create(CameraKind::kSimpleRadial, 640, 480, parameters), {}, {}, {}, 0};
  pair.first_from_second =
      Rigid3(RotationFromVector(random.Vector(0.1)), baseline * random.Vector(1).normalized());
  pair.inlier_count = static_cast<std::size_t>(inlier_share * static_cast<double>(count));
  const auto noisy = [&](const Eigen::Vector2d& pixel_px) {
    return Eigen::Vector2d(pixel_px.x() + random.Normal(noise_px),
                           pixel_px.y() + random.Normal(noise_px));
  };
  while (pair.first_px.size() < count) {
    const Eigen::Vector2d pixel_px(random.Uniform(0, 640), random.Uniform(0, 480));
    const Eigen::Vector3d ray = pair.camera.Unproject(pixel_px);
    const Eigen::Vector3d normal(0.2, -0.3, 1);
    const double depth = shape == Shape::kPlane ? 8 / normal.dot(ray) : random.Uniform(4, 20);
    const auto other = pair.camera.Project(pair.first_from_second.Inverse() * (depth * ray));
    if (!other || !pair.camera.Contains(*other)) continue;
    const bool inlier = pair.first_px.size() < pair.inlier_count;
    pair.first_px.push_back(noisy(pixel_px));
    pair.second_px.push_back(
        inlier ? noisy(*other) : Eigen::Vector2d(random.Uniform(0, 640), random.Uniform(0, 480)));
  }
  return pair;
}

std::optional<TwoViewGeometry> Estimate(const Pair& pair) {
  return *EstimateTwoView(pair.camera, pair.camera, pair.first_px, pair.second_px, {});
}

double RotationError(const Pair& pair, const TwoViewGeometry& view) {
  return AngleBetween(pair.first_from_second.rotation(), view.first_from_second.rotation())
      .radians();
}

double DirectionError(const Pair& pair, const TwoViewGeometry& view) {
  return (pair.first_from_second.translation().normalized() - view.first_from_second.translation())
      .norm();
}

TEST(TwoView, IsExactForExactMatches) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Pair pair = MakePair(seed, 100, 1, 0, 2);
    const auto view = Estimate(pair);
    ASSERT_TRUE(view);
    EXPECT_EQ(view->kind, TwoViewKind::kGeneral) << view->homography_share;
    EXPECT_EQ(view->inliers.size(), 100U);
    EXPECT_LT(RotationError(pair, *view), 1e-7);
    EXPECT_LT(DirectionError(pair, *view), 1e-6);
  }
}

TEST(TwoView, WithstandsNoiseAndOutliers) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Pair pair = MakePair(seed, 300, 0.4, 0.5, 2);
    const auto view = Estimate(pair);
    ASSERT_TRUE(view);
    EXPECT_LT(RotationError(pair, *view), 0.02);
    EXPECT_LT(DirectionError(pair, *view), 0.1);
    std::size_t wrong = 0;
    for (std::uint32_t i : view->inliers) wrong += i >= pair.inlier_count ? 1 : 0;
    EXPECT_GE(view->inliers.size() - wrong, pair.inlier_count * 9 / 10);
    EXPECT_LE(wrong, 20U);
  }
}

TEST(TwoView, RecognisesAPlane) {
  const auto view = Estimate(MakePair(3, 200, 0.8, 0.5, 2, Shape::kPlane));
  ASSERT_TRUE(view);
  EXPECT_EQ(view->kind, TwoViewKind::kPlanar);
}

TEST(TwoView, RecognisesPureRotation) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Pair pair = MakePair(seed, 200, 0.7, 0.5, 0);
    const auto view = Estimate(pair);
    ASSERT_TRUE(view);
    EXPECT_EQ(view->kind, TwoViewKind::kRotation);
    EXPECT_LT(RotationError(pair, *view), 0.002);
    EXPECT_GE(view->inliers.size(), 135U);
  }
}

TEST(TwoView, ReportsNothingForUnrelatedViews) {
  EXPECT_FALSE(Estimate(MakePair(1, 60, 0, 0.5, 2)));
  EXPECT_FALSE(Estimate(MakePair(1, 10, 1, 0.5, 2)));
}

TEST(TwoView, RejectsUnequalLengths) {
  Pair pair = MakePair(1, 20, 1, 0, 1);
  pair.first_px.pop_back();
  EXPECT_FALSE(EstimateTwoView(pair.camera, pair.camera, pair.first_px, pair.second_px, {}).ok());
}

}  // namespace
}  // namespace waymark::mapping
