// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/median.h"

#include <gtest/gtest.h>

namespace waymark {
namespace {

TEST(Median, OfAnOddNumberIsTheOneInTheMiddle) {
  EXPECT_EQ(Median({7}), 7);
  EXPECT_EQ(Median({9, -1, 4}), 4);
  EXPECT_EQ(Median({3, 3, 1, 8, 2}), 3);
}

TEST(Median, OfAnEvenNumberIsTheUpperOfTwo) {
  EXPECT_EQ(Median({2, 1}), 2);
  EXPECT_EQ(Median({4, 1, 3, 2}), 3);
}

TEST(Median, LeavesTheCallersValuesAsTheyAre) {
  const std::vector<double> values{5, 1, 3};
  EXPECT_EQ(Median(values), 3);
  EXPECT_EQ(values, (std::vector<double>{5, 1, 3}));
}

TEST(MedianDeathTest, OfNothingIsOurOwnMistake) { EXPECT_DEATH(Median({}), "values.empty"); }

}  // namespace
}  // namespace waymark
