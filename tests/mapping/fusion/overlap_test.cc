// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/overlap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <tuple>

namespace waymark::mapping {
namespace {

using testing::ElementsAreArray;
using testing::HasSubstr;
using Numbers = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t>;

/// Submaps that hold every image with probability 0.3, in any order; numbers far apart.
std::vector<FusionSubmap> MakeSubmaps(int count, int images, unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<std::uint64_t> numbers(static_cast<std::size_t>(images));
  for (std::uint64_t& number : numbers) number = random();
  std::vector<FusionSubmap> submaps(static_cast<std::size_t>(count));
  for (FusionSubmap& submap : submaps) {
    std::shuffle(numbers.begin(), numbers.end(), random);
    for (const std::uint64_t number : numbers) {
      if (random() % 10 < 3) submap.images.push_back({.image = number, .submap_from_camera = {}});
    }
  }
  return submaps;
}

/// First and second submap, index in the second and in the first, in this order.
std::vector<Numbers> CompareAll(const std::vector<FusionSubmap>& submaps) {
  std::vector<Numbers> shared;
  for (std::uint32_t first = 0; first < submaps.size(); ++first) {
    for (std::uint32_t second = first + 1; second < submaps.size(); ++second) {
      for (std::uint32_t j = 0; j < submaps[second].images.size(); ++j) {
        for (std::uint32_t i = 0; i < submaps[first].images.size(); ++i) {
          if (submaps[first].images[i].image != submaps[second].images[j].image) continue;
          shared.emplace_back(first, second, j, i);
        }
      }
    }
  }
  return shared;
}

TEST(Overlap, HoldsAllThatTwoSubmapsShare) {
  for (const auto& [count, images] : {std::pair(0, 0), std::pair(1, 9), std::pair(2, 1),
                                      std::pair(3, 40), std::pair(12, 60), std::pair(40, 5)}) {
    const std::vector<FusionSubmap> submaps = MakeSubmaps(count, images, 5);
    const auto overlaps = FindOverlaps(submaps);
    ASSERT_TRUE(overlaps.ok());
    std::vector<Numbers> found;
    for (const Overlap& overlap : *overlaps) {
      EXPECT_FALSE(overlap.images.empty());
      for (const SharedImage& image : overlap.images) {
        found.emplace_back(overlap.first, overlap.second, image.in_second, image.in_first);
      }
    }
    EXPECT_THAT(found, ElementsAreArray(CompareAll(submaps)));
  }
}

TEST(Overlap, RefusesASubmapThatHoldsAnImageTwice) {
  std::vector<FusionSubmap> submaps = MakeSubmaps(4, 20, 6);
  submaps[2].images.push_back(submaps[2].images.front());
  const auto overlaps = FindOverlaps(submaps);
  ASSERT_FALSE(overlaps.ok());
  EXPECT_EQ(overlaps.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(overlaps.error().message, HasSubstr("submap 2 holds image"));
}

}  // namespace
}  // namespace waymark::mapping
