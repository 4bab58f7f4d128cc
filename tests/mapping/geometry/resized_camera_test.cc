// SPDX-License-Identifier: Apache-2.0
#include "mapping/geometry/resized_camera.h"

#include <gtest/gtest.h>

#include <vector>

namespace waymark {
namespace {

TEST(ResizedCamera, SeesTheSame) {
  const std::vector<std::vector<double>> parameters{
      {500, 320, 240},
      {500, 510, 320, 240},
      {500, 320, 240, -0.1},
      {500, 320, 240, -0.1, 0.02},
      {500, 510, 320, 240, -0.1, 0.02, 0.001, -0.002}};
  for (std::size_t kind = 0; kind < parameters.size(); ++kind) {
    const auto camera =
        CameraModel::Create(static_cast<CameraKind>(kind), 640, 480, parameters[kind]);
    const CameraModel half = ResizeCamera(*camera, 320, 240);
    EXPECT_EQ(half.width_px(), 320);
    EXPECT_EQ(half.height_px(), 240);
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(0, 0), Eigen::Vector2d(500, 70)}) {
      EXPECT_LT((half.Unproject(pixel / 2) - camera->Unproject(pixel)).norm(), 1e-9);
    }
  }
}

TEST(ResizedCamera, APrincipalPointMovesAllAlike) {
  const auto camera = CameraModel::Create(
      CameraKind::kOpenCv, 640, 480, std::vector<double>{500, 510, 320, 240, -0.1, 0.02, 0, 0});
  const CameraModel moved = WithPrincipalPoint(*camera, {330, 235});
  EXPECT_EQ(moved.PrincipalPoint(), Eigen::Vector2d(330, 235));
  const Eigen::Vector2d pixel(500, 70);
  EXPECT_EQ(moved.Unproject(pixel + Eigen::Vector2d(10, -5)), camera->Unproject(pixel));
}

}  // namespace
}  // namespace waymark
