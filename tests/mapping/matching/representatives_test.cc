// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/representatives.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <vector>

namespace waymark::mapping {
namespace {

using testing::ElementsAre;

/// A descriptor in the plane of two components, at an angle from the first.
Descriptor At(double angle_rad) {
  Descriptor descriptor{};
  // Spread over four components each, so that none exceeds 255.
  for (std::size_t i = 0; i < 4; ++i) {
    descriptor[i] = static_cast<std::uint8_t>(std::lround(255 * std::cos(angle_rad)));
    descriptor[4 + i] = static_cast<std::uint8_t>(std::lround(255 * std::sin(angle_rad)));
  }
  return descriptor;
}

TEST(Representatives, OneStandsForItself) {
  EXPECT_THAT(ChooseRepresentatives(std::vector<Descriptor>{At(0.3)}, {}), ElementsAre(0));
}

TEST(Representatives, TheMiddleOneStandsForAll) {
  EXPECT_THAT(ChooseRepresentatives(std::array{At(0.2), At(0.9), At(0.5)}, {.max_count = 1}),
              ElementsAre(2));
}

TEST(Representatives, TwoLooksHaveOneEach) {
  const std::array descriptors{At(0.1), At(1.4), At(0.11), At(1.41), At(0.12)};
  const auto chosen = ChooseRepresentatives(descriptors, {.max_count = 4});
  ASSERT_EQ(chosen.size(), 2U);
  EXPECT_EQ(chosen[0] % 2, 0U) << "the look of three comes first";
  EXPECT_EQ(chosen[1] % 2, 1U);
}

TEST(Representatives, EqualOnesNeedOne) {
  EXPECT_THAT(ChooseRepresentatives(std::vector<Descriptor>(5, At(0.4)), {}), ElementsAre(0));
}

}  // namespace
}  // namespace waymark::mapping
