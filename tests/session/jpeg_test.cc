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

}  // namespace
}  // namespace waymark::session
