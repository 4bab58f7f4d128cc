// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/upright_pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "mapping/estimation/absolute_pose.h"
#include "tests/support/random_geometry.h"

namespace waymark::mapping {
namespace {

/// A camera anywhere, and what is up for it.
struct View {
  Rigid3 world_from_camera;
  SharedUp up;
};

View MakeView(support::RandomGeometry& random) {
  View view{{random.Rotation(), random.Vector(50)}, {}};
  view.up.in_world = random.Vector(1).normalized();
  view.up.in_camera = view.world_from_camera.rotation().conjugate() * view.up.in_world;
  return view;
}

Eigen::Vector3d SeenPoint(const View& view, const Eigen::Vector3d& bearing, double distance_m) {
  return view.world_from_camera * Eigen::Vector3d(distance_m * bearing);
}

TEST(UprightPose, IsExactForTwoExactPoints) {
  support::RandomGeometry random(1);
  for (int trial = 0; trial < 500; ++trial) {
    const View view = MakeView(random);
    std::array<Eigen::Vector3d, 2> bearings, points;
    for (std::size_t i = 0; i < 2; ++i) {
      bearings[i] = random.Vector(1).normalized();
      points[i] = SeenPoint(view, bearings[i], random.Uniform(2, 40));
    }
    std::vector<Rigid3> poses;
    UprightPoseSolver(view.up).Solve(bearings, points, poses);
    ASSERT_FALSE(poses.empty());
    ASSERT_LE(poses.size(), 2U);
    double least = 1e9;
    for (const Rigid3& pose : poses) {
      least = std::min(least, Difference(pose, view.world_from_camera).norm());
      EXPECT_LT((pose.rotation() * view.up.in_camera - view.up.in_world).norm(), 1e-12);
    }
    EXPECT_LT(least, 1e-6);
  }
}

TEST(UprightPose, PointsThatTellNothingGiveNoPose) {
  const UprightPoseSolver solver(
      {.in_camera = Eigen::Vector3d(0, -1, 0), .in_world = Eigen::Vector3d::UnitZ()});
  const Eigen::Vector3d ahead(0, 0, 1), aside = Eigen::Vector3d(0.3, 0, 1).normalized();
  std::vector<Rigid3> poses;
  solver.Solve({ahead, aside}, {Eigen::Vector3d(0, 5, 0), Eigen::Vector3d(2, 5, 0)}, poses);
  EXPECT_TRUE(poses.empty()) << "both at the camera's height";
  const Eigen::Vector3d above = Eigen::Vector3d(0, -0.3, 1).normalized();
  solver.Solve({ahead, above}, {Eigen::Vector3d(0, 5, 0), Eigen::Vector3d(0, 5, 2)}, poses);
  EXPECT_TRUE(poses.empty()) << "one above the other: any heading";
}

TEST(UprightPose, HelpsTheRobustLoopThoughGravityIsOffByADegree) {
  support::RandomGeometry random(3);
  const std::array parameters{500.0, 500.0, 320.0, 240.0};
  const CameraModel camera = *CameraModel::Create(CameraKind::kPinhole, 640, 480, parameters);
  for (int trial = 0; trial < 20; ++trial) {
    View view = MakeView(random);
    view.up.in_camera = RotationFromVector(random.Vector(0.017)) * view.up.in_camera;
    std::vector<Eigen::Vector2d> pixels_px;
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector2d pixel_px(random.Uniform(0, 640), random.Uniform(0, 480));
      points.push_back(SeenPoint(view, camera.Unproject(pixel_px), random.Uniform(4, 40)));
      pixels_px.push_back(i < 60 ? Eigen::Vector2d(pixel_px.x() + random.Normal(1),
                                                   pixel_px.y() + random.Normal(1))
                                 : Eigen::Vector2d(random.Uniform(0, 640), random.Uniform(0, 480)));
    }
    const auto with = EstimateAbsolutePose(camera, pixels_px, points, {}, {.up = view.up});
    const auto without = EstimateAbsolutePose(camera, pixels_px, points, {}, {});
    ASSERT_TRUE(with.ok() && *with && without.ok() && *without);
    EXPECT_EQ((*with)->inliers, (*without)->inliers);
    EXPECT_LT((*with)->iterations, (*without)->iterations);
  }
}

}  // namespace
}  // namespace waymark::mapping
