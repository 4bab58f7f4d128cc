// SPDX-License-Identifier: Apache-2.0
#include "session/device/jpeg.h"

#include <gtest/gtest.h>

namespace waymark::session {
namespace {

TEST(Jpeg, RefusesSizesThatDoNotMatch) {
  const std::vector<std::uint8_t> pixels(12, 7);
  EXPECT_TRUE(EncodeJpeg(pixels, 4, 3, 85).ok());
  EXPECT_EQ(EncodeJpeg(pixels, 4, 4, 85).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(EncodeJpeg(pixels, -4, -3, 85).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace waymark::session
