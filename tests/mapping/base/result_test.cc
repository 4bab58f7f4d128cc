// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/result.h"

#include <gmock/gmock.h>

#include <memory>

namespace waymark {
namespace {

Result<int> Half(int number) {
  if (number % 2 != 0)
    return MakeError(ErrorCode::kInvalidArgument, "expected even, found {}", number);
  return number / 2;
}

Result<int> Quarter(int number) {
  WAYMARK_TRY_ASSIGN(const int half, Half(number));
  return Half(half);
}

Result<void> CheckEven(int number) {
  WAYMARK_TRY(Half(number));
  return {};
}

TEST(Result, CarriesAValue) {
  const auto result = Quarter(12);
  ASSERT_TRUE(result);
  EXPECT_EQ(*result, 3);
}

TEST(Result, CarriesTheFirstError) {
  const auto result = Quarter(10);
  ASSERT_FALSE(result);
  EXPECT_EQ(ToString(result.error()), "invalid argument: expected even, found 5");
}

TEST(Result, OfVoidReportsSuccessAndFailure) {
  EXPECT_TRUE(CheckEven(2));
  EXPECT_FALSE(CheckEven(3));
}

TEST(Result, HoldsMoveOnlyValues) {
  Result<std::unique_ptr<int>> result = std::make_unique<int>(7);
  const std::unique_ptr<int> value = *std::move(result);
  EXPECT_EQ(*value, 7);
}

TEST(ResultDeathTest, ReadingAFailureAbortsWithItsText) {
  const auto result = Half(3);
  EXPECT_DEATH((void)result.value(), "expected even, found 3");
}

}  // namespace
}  // namespace waymark
