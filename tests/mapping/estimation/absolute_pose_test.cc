// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/absolute_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <array>

#include "tests/support/random_geometry.h"

namespace waymark::mapping {
namespace {

struct Scene {
  CameraModel camera;
  Rigid3 world_from_camera;
  std::vector<Eigen::Vector2d> pixels_px;
  std::vector<Eigen::Vector3d> points_in_world;
  std::vector<double> quality;
  std::size_t inlier_count;
};

CameraModel TestCamera(CameraKind kind = CameraKind::kPinhole) {
  if (kind == CameraKind::kOpenCv) {
    const std::array p{500.0, 510.0, 320.0, 240.0, -0.1, 0.03, 0.001, -0.002};
    return *CameraModel::Create(kind, 640, 480, p);
  }
  const std::array p{500.0, 500.0, 320.0, 240.0};
  return *CameraModel::Create(kind, 640, 480, p);
}

// Inliers first. Quality is informative but far from perfect.
Scene MakeScene(std::uint64_t seed, std::size_t count, double inlier_share, double noise_px,
                const CameraModel& camera = TestCamera()) {
  support::RandomGeometry random(seed);
  const Eigen::Vector3d place = random.Vector(100);
  Scene scene{camera, {random.Rotation(), place}, {}, {}, {}, 0};
  scene.inlier_count = static_cast<std::size_t>(inlier_share * static_cast<double>(count));
  while (scene.pixels_px.size() < count) {
    const Eigen::Vector2d pixel_px(random.Uniform(0, 640), random.Uniform(0, 480));
    const Eigen::Vector3d x_in_camera = random.Uniform(4, 40) * camera.Unproject(pixel_px);
    const bool inlier = scene.pixels_px.size() < scene.inlier_count;
    scene.points_in_world.push_back(scene.world_from_camera * x_in_camera);
    scene.pixels_px.push_back(
        inlier ? Eigen::Vector2d(pixel_px.x() + random.Normal(noise_px),
                                 pixel_px.y() + random.Normal(noise_px))
               : Eigen::Vector2d(random.Uniform(0, 640), random.Uniform(0, 480)));
    scene.quality.push_back((inlier ? 0.5 : 0.0) + random.Uniform(0, 1));
  }
  return scene;
}

std::optional<AbsolutePose> Estimate(const Scene& scene, const AbsolutePoseOptions& options = {}) {
  return *EstimateAbsolutePose(scene.camera, scene.pixels_px, scene.points_in_world, scene.quality,
                               options);
}

TEST(AbsolutePose, IsExactForExactMatches) {
  for (CameraKind kind : {CameraKind::kPinhole, CameraKind::kOpenCv}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const Scene scene = MakeScene(seed, 50, 1, 0, TestCamera(kind));
      const auto pose = Estimate(scene);
      ASSERT_TRUE(pose);
      EXPECT_EQ(pose->inliers.size(), 50U);
      EXPECT_LT(Difference(pose->world_from_camera, scene.world_from_camera).norm(), 1e-7);
    }
  }
}

class AbsolutePoseWithOutliers : public testing::TestWithParam<double> {};

TEST_P(AbsolutePoseWithOutliers, FindsThePose) {
  int found = 0;
  constexpr int kScenes = 50;
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    const Scene scene = MakeScene(seed, 200, GetParam(), 1);
    const auto pose = Estimate(scene);
    if (!pose) continue;
    const auto error = Difference(scene.world_from_camera, pose->world_from_camera);
    if (error.head<3>().norm() < 0.25 && error.tail<3>().norm() < 0.02) ++found;
  }
  EXPECT_GE(found, kScenes - 1);
}

INSTANTIATE_TEST_SUITE_P(InlierShare, AbsolutePoseWithOutliers, testing::Values(0.1, 0.3, 0.7));

TEST(AbsolutePose, FindsAnotherFocalLengthWhereMatchesContradictTheStatedOne) {
  Scene scene = MakeScene(3, 400, 0.7, 0.5);
  scene.camera = scene.camera.WithScaledFocal(1.03);
  const auto believed = Estimate(scene);
  const auto doubted = Estimate(scene, {.focal_sigma_share = 0.05});
  ASSERT_TRUE(believed && doubted);
  EXPECT_NEAR(doubted->focal_factor, 1 / 1.03, 0.001);
  EXPECT_LT(
      (doubted->world_from_camera.translation() - scene.world_from_camera.translation()).norm(),
      0.03);
  EXPECT_EQ(believed->focal_factor, 1);
  EXPECT_GT(doubted->inliers.size(), believed->inliers.size());
}

TEST(AbsolutePose, KeepsAnExactFocalLengthInDoubt) {
  const Scene scene = MakeScene(4, 400, 0.7, 0.5);
  const auto believed = Estimate(scene);
  const auto doubted = Estimate(scene, {.focal_sigma_share = 0.05});
  ASSERT_TRUE(believed && doubted);
  EXPECT_EQ(doubted->focal_factor, 1);
  EXPECT_EQ(Difference(doubted->world_from_camera, believed->world_from_camera).norm(), 0);
}

TEST(AbsolutePose, FindsOutliersWithoutQuality) {
  Scene scene = MakeScene(5, 200, 0.2, 0.5);
  scene.quality.clear();
  const auto pose = Estimate(scene);
  ASSERT_TRUE(pose);
  EXPECT_GE(pose->inliers.size(), scene.inlier_count);
}

TEST(AbsolutePose, ReportsNoPoseWhenThereIsNone) {
  EXPECT_FALSE(Estimate(MakeScene(1, 200, 0, 1), {.max_iterations = 2000}));
  EXPECT_FALSE(Estimate(MakeScene(1, 3, 1, 0)));
}

TEST(AbsolutePose, RejectsPointsThatDetermineNoPose) {
  Scene scene = MakeScene(1, 40, 1, 0);
  for (std::size_t i = 0; i < 40; ++i) {  // all on one line
    scene.points_in_world[i] =
        scene.world_from_camera * Eigen::Vector3d(0.1 * static_cast<double>(i), 1, 10);
    scene.pixels_px[i] =
        *scene.camera.Project(scene.world_from_camera.Inverse() * scene.points_in_world[i]);
  }
  EXPECT_FALSE(Estimate(scene));
}

TEST(AbsolutePose, RejectsUnequalLengths) {
  Scene scene = MakeScene(1, 20, 1, 0);
  scene.pixels_px.pop_back();
  const auto result =
      EstimateAbsolutePose(scene.camera, scene.pixels_px, scene.points_in_world, scene.quality, {});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
}

TEST(AbsolutePose, IsTheSameForTheSameSeed) {
  const Scene scene = MakeScene(3, 200, 0.3, 1);
  const auto a = Estimate(scene);
  const auto b = Estimate(scene);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->inliers, b->inliers);
  EXPECT_EQ(a->iterations, b->iterations);
  EXPECT_EQ(Difference(a->world_from_camera, b->world_from_camera).norm(), 0);
}

// The squared error in units of the reported covariance follows a chi-square law of 6 degrees of
// freedom: mean 6.
TEST(AbsolutePose, CovarianceAgreesWithTheErrors) {
  double sum = 0;
  constexpr int kScenes = 200;
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    const Scene scene = MakeScene(seed, 100, 0.8, 1, TestCamera(CameraKind::kOpenCv));
    const auto pose = Estimate(scene);
    ASSERT_TRUE(pose);
    const auto error = Difference(pose->world_from_camera, scene.world_from_camera);
    sum += error.dot(pose->covariance.ldlt().solve(error));
  }
  EXPECT_GT(sum / kScenes, 5);
  EXPECT_LT(sum / kScenes, 7.5);
}

}  // namespace
}  // namespace waymark::mapping
