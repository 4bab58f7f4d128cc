// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/kept_buffer.h"

#include <gmock/gmock.h>

#include <cstdint>

namespace waymark::mapping::internal {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;

TEST(KeptBuffer, ServesTheNextOfItsSize) {
  void* first = nullptr;
  {
    const auto buffer = KeptBuffer::Take(20 * kMiB);
    ASSERT_TRUE(buffer.ok());
    first = buffer->data();
  }
  for (const std::size_t bytes : {20 * kMiB, 19 * kMiB}) {
    const auto buffer = KeptBuffer::Take(bytes);
    ASSERT_TRUE(buffer.ok());
    EXPECT_EQ(buffer->data(), first) << bytes;
  }
}

TEST(KeptBuffer, GivesDifferentMemoryToThoseThatHoldIt) {
  const auto a = KeptBuffer::Take(3 * kMiB), b = KeptBuffer::Take(3 * kMiB);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_NE(a->data(), b->data());
}

TEST(KeptBuffer, SaysHowMuchWasRefused) {
  const auto buffer = KeptBuffer::Take(SIZE_MAX / 4);
  ASSERT_FALSE(buffer.ok());
  EXPECT_EQ(buffer.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(buffer.error().message, testing::HasSubstr(std::to_string(SIZE_MAX / 4)));
}

}  // namespace
}  // namespace waymark::mapping::internal
