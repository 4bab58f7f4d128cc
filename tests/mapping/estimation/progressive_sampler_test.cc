// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/progressive_sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace waymark::mapping {
namespace {

TEST(ProgressiveSampler, StartsWithTheMostPromisingAndEndsWithAll) {
  std::vector<double> quality(100);
  for (std::size_t i = 0; i < quality.size(); ++i) quality[i] = static_cast<double>(i);
  ProgressiveSampler sampler(100, quality, 3, 2000, 7);
  std::vector<std::uint32_t> sample(3);
  sampler.Draw(sample);
  std::sort(sample.begin(), sample.end());
  EXPECT_EQ(sample, (std::vector<std::uint32_t>{97, 98, 99}));
  std::set<std::uint32_t> seen;
  for (int i = 0; i < 4000; ++i) {
    sampler.Draw(sample);
    EXPECT_EQ(std::set<std::uint32_t>(sample.begin(), sample.end()).size(), 3U);
    seen.insert(sample.begin(), sample.end());
  }
  EXPECT_EQ(sampler.pool(), 100U);
  EXPECT_EQ(seen.size(), 100U);
}

TEST(ProgressiveSampler, IsUniformWithoutQuality) {
  ProgressiveSampler sampler(10, {}, 2, 1000, 1);
  std::vector<int> counts(10);
  std::vector<std::uint32_t> sample(2);
  for (int i = 0; i < 10000; ++i) {
    sampler.Draw(sample);
    for (std::uint32_t k : sample) ++counts[k];
  }
  for (int count : counts) EXPECT_NEAR(count, 2000, 200);
}

TEST(ProgressiveSampler, DependsOnlyOnTheSeed) {
  std::vector<std::uint32_t> a(3);
  std::vector<std::uint32_t> b(3);
  ProgressiveSampler first(50, {}, 3, 100, 9);
  ProgressiveSampler second(50, {}, 3, 100, 9);
  for (int i = 0; i < 100; ++i) {
    first.Draw(a);
    second.Draw(b);
    EXPECT_EQ(a, b);
  }
}

TEST(ProgressiveSampler, DrawsWholeSetsOfMinimalSize) {
  const std::vector<double> quality{1, 2, 3};
  ProgressiveSampler sampler(3, quality, 3, 10, 1);
  std::vector<std::uint32_t> sample(3);
  for (int i = 0; i < 20; ++i) {
    sampler.Draw(sample);
    std::sort(sample.begin(), sample.end());
    EXPECT_EQ(sample, (std::vector<std::uint32_t>{0, 1, 2}));
  }
}

}  // namespace
}  // namespace waymark::mapping
