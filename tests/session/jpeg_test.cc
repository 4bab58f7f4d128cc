// SPDX-License-Identifier: Apache-2.0
#include "session/device/jpeg.h"

#include <gtest/gtest.h>

namespace waymark::session {
namespace {

TEST(Jpeg, RefusesSizesThatDoNotMatch) {
  const std::vector<std::uint8_t> pixels(12, 7);
  EXPECT_TRUE(EncodeJpeg(pixels, 4, 3, {}).ok());
  EXPECT_EQ(EncodeJpeg(pixels, 4, 4, {}).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(EncodeJpeg(pixels, -4, -3, {}).error().code, ErrorCode::kInvalidArgument);
}

TEST(Jpeg, ReducesTheLongerSideAndNeverEnlarges) {
  const std::vector<std::uint8_t> pixels(64 * 20, 7);
  const auto reduced = EncodeJpeg(pixels, 64, 20, {.max_side_px = 32});
  ASSERT_TRUE(reduced.ok());
  EXPECT_EQ(reduced->width_px, 32);
  EXPECT_EQ(reduced->height_px, 10);
  EXPECT_EQ(EncodeJpeg(pixels, 20, 64, {.max_side_px = 32})->height_px, 32);
  EXPECT_EQ(EncodeJpeg(pixels, 64, 20, {.max_side_px = 640})->width_px, 64);
  EXPECT_EQ(EncodeJpeg(pixels, 64, 20, {.max_side_px = 1})->height_px, 1);
}

TEST(Jpeg, AResizedCameraSeesTheSame) {
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

}  // namespace
}  // namespace waymark::session
