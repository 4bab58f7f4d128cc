// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/working_runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

namespace waymark::mapping::internal {
namespace {

TEST(WorkingRuns, GivesARunThatIsFreeToTheNextOfItsSize) {
  WorkingRuns runs;
  const std::uint32_t three = runs.Take(3), five = runs.Take(5);
  EXPECT_EQ(runs.extent(), 8u);
  runs.Give(three, 3);
  EXPECT_NE(runs.Take(5), five);
  EXPECT_EQ(runs.Take(3), three);
  EXPECT_EQ(runs.extent(), 13u);
}

TEST(WorkingRuns, RunsInUseDoNotMeet) {
  std::mt19937 random(3);
  WorkingRuns runs;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> used;  // begin, size
  for (int i = 0; i < 2000; ++i) {
    if (!used.empty() && random() % 2 == 0) {
      std::swap(used[random() % used.size()], used.back());
      runs.Give(used.back().first, used.back().second);
      used.pop_back();
      continue;
    }
    const auto size = static_cast<std::uint32_t>(1 + random() % 9);
    const std::uint32_t begin = runs.Take(size);
    ASSERT_LE(begin + size, runs.extent());
    for (const auto& [other, others] : used) {
      ASSERT_TRUE(begin + size <= other || other + others <= begin) << begin << ", " << other;
    }
    used.emplace_back(begin, size);
  }
}

}  // namespace
}  // namespace waymark::mapping::internal
