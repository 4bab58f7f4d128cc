// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/radix_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace waymark::mapping {
namespace {

TEST(RadixSort, SortsAsAStableSortDoes) {
  std::mt19937_64 random(1);
  for (const int bits : {0, 1, 11, 12, 40, 64}) {
    LargeVector<std::pair<std::uint64_t, int>> items;
    for (int i = 0; i < 1000; ++i) items.emplace_back(bits == 0 ? 7 : random() >> (64 - bits), i);
    auto expected = items;
    std::ranges::stable_sort(expected, {}, [](const auto& item) { return item.first; });
    RadixSort(items, [](const auto& item) { return item.first; });
    EXPECT_EQ(items, expected) << bits << " bits";
  }
  LargeVector<std::pair<std::uint64_t, int>> none;
  RadixSort(none, [](const auto& item) { return item.first; });
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace waymark::mapping
