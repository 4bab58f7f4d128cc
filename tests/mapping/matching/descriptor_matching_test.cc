// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/descriptor_matching.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "mapping/matching/internal/nearest_two_kernels.h"
#include "tests/mapping/matching/random_descriptors.h"

namespace waymark::mapping {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// The definition, written without any cleverness.
NearestTwo NearestByDefinition(const Descriptor& query, std::span<const Descriptor> database) {
  std::vector<std::int32_t> dots;
  for (const Descriptor& entry : database) {
    dots.push_back(std::inner_product(query.begin(), query.end(), entry.begin(), 0));
  }
  NearestTwo nearest;
  if (dots.empty()) return nearest;
  const auto best = std::ranges::max_element(dots);  // the first among equals
  nearest.first = static_cast<std::uint32_t>(best - dots.begin());
  nearest.first_dot = *best;
  dots.erase(best);
  if (!dots.empty()) nearest.second_dot = std::ranges::max(dots);
  return nearest;
}

void ExpectSame(const NearestTwo& found, const NearestTwo& expected) {
  EXPECT_EQ(found.first, expected.first);
  EXPECT_EQ(found.first_dot, expected.first_dot);
  EXPECT_EQ(found.second_dot, expected.second_dot);
}

TEST(NearestTwoKernels, EachFollowsTheDefinition) {
  std::mt19937 random(1);
  for (const auto& kernel : internal::SupportedNearestTwoKernels()) {
    SCOPED_TRACE(kernel.name);
    for (const std::size_t database_size :
         {0, 1, 2, 7, 8, 9, 15, 16, 17, 31, 63, 64, 65, 127, 128, 129, 192, 300}) {
      for (const std::size_t query_count : {0, 1, 3, 4, 5, 9}) {
        const auto queries = RandomBytes(query_count, random);
        const auto database = RandomBytes(database_size, random);
        const auto found = internal::FindNearestTwo(kernel, queries, database);
        ASSERT_EQ(found.size(), query_count);
        for (std::size_t q = 0; q < query_count; ++q) {
          ExpectSame(found[q], NearestByDefinition(queries[q], database));
        }
      }
    }
  }
}

TEST(NearestTwoKernels, QueriesSeeTheEntriesOfTheirCellsOnly) {
  std::mt19937 random(20);
  const auto queries = RandomBytes(60, random), database = RandomBytes(400, random);
  // Cells of many sizes, two of them empty; each query is in three cells, one of no query.
  std::vector<std::uint32_t> entry_begins{0, 1, 1, 17, 90, 300, 300}, entries(300);
  for (std::uint32_t i = 0; i < entries.size(); ++i) entries[i] = 7 * i % 400;
  std::vector<std::uint32_t> query_begins{0}, cell_queries;
  for (std::uint32_t cell = 0; cell < 6; ++cell) {
    for (std::uint32_t q = 0; q < queries.size(); ++q) {
      if ((q + cell) % 2 == 0 && cell != 3) cell_queries.push_back(q);
    }
    query_begins.push_back(static_cast<std::uint32_t>(cell_queries.size()));
  }
  for (const auto& kernel : internal::SupportedNearestTwoKernels()) {
    SCOPED_TRACE(kernel.name);
    const auto found =
        kernel.find(queries, database, {query_begins, cell_queries, entry_begins, entries});
    for (std::uint32_t q = 0; q < queries.size(); ++q) {
      std::vector<Descriptor> seen;
      std::vector<std::uint32_t> numbers;
      for (std::uint32_t cell = 0; cell < 6; ++cell) {
        if ((q + cell) % 2 != 0 || cell == 3) continue;
        for (std::uint32_t i = entry_begins[cell]; i < entry_begins[cell + 1]; ++i) {
          seen.push_back(database[entries[i]]);
          numbers.push_back(entries[i]);
        }
      }
      NearestTwo expected = NearestByDefinition(queries[q], seen);
      if (!seen.empty()) expected.first = numbers[expected.first];
      ExpectSame(found[q], expected);
    }
  }
}

TEST(NearestTwoKernels, AgreeOnExtremeValues) {
  std::mt19937 random(2);
  std::vector<Descriptor> extremes;
  for (const int value : {0, 1, 127, 128, 254, 255}) {
    extremes.emplace_back().fill(static_cast<std::uint8_t>(value));
  }
  for (int i = 0; i < 100; ++i) {
    for (std::uint8_t& value : extremes.emplace_back()) value = random() % 2 == 0 ? 0 : 255;
  }
  for (const auto& kernel : internal::SupportedNearestTwoKernels()) {
    SCOPED_TRACE(kernel.name);
    const auto found = internal::FindNearestTwo(kernel, extremes, extremes);
    for (std::size_t q = 0; q < extremes.size(); ++q) {
      ExpectSame(found[q], NearestByDefinition(extremes[q], extremes));
    }
  }
}

TEST(NearestTwoKernels, TiesGoToTheLowerIndex) {
  std::mt19937 random(3);
  for (const auto& kernel : internal::SupportedNearestTwoKernels()) {
    SCOPED_TRACE(kernel.name);
    auto database = RandomRootSift(500, random);
    const Descriptor query = database[0];
    database[0] = RandomRootSift(1, random)[0];
    for (const std::size_t place : {499, 333, 130, 129, 77, 16, 5}) {
      const std::int32_t second_dot =
          place == 499 ? NearestByDefinition(query, database).first_dot
                       : std::inner_product(query.begin(), query.end(), query.begin(), 0);
      database[place] = query;  // one more copy, before all others
      const auto found = internal::FindNearestTwo(kernel, std::span(&query, 1), database);
      EXPECT_EQ(found[0].first, place);
      EXPECT_EQ(found[0].second_dot, second_dot);
    }
  }
}

TEST(NearestTwoKernels, DoNotDependOnAlignment) {
  std::mt19937 random(4);
  std::vector<std::uint8_t> storage(128 * 41 + 1);
  for (std::uint8_t& value : storage) value = static_cast<std::uint8_t>(random());
  const std::span unaligned(reinterpret_cast<const Descriptor*>(storage.data() + 1), 41);
  const std::vector<Descriptor> aligned(unaligned.begin(), unaligned.end());
  for (const auto& kernel : internal::SupportedNearestTwoKernels()) {
    const auto a = internal::FindNearestTwo(kernel, aligned, aligned);
    const auto b = internal::FindNearestTwo(kernel, unaligned, unaligned);
    for (std::size_t q = 0; q < a.size(); ++q) ExpectSame(a[q], b[q]);
  }
}

TEST(NearestTwoKernels, TheLastIsPortableAndTheFirstIsUsed) {
  const auto kernels = internal::SupportedNearestTwoKernels();
  ASSERT_FALSE(kernels.empty());
  EXPECT_EQ(kernels.back().name, "portable");
  std::mt19937 random(5);
  const auto queries = RandomRootSift(50, random), database = RandomRootSift(70, random);
  const auto found = FindNearestTwo(queries, database);
  const auto expected = internal::FindNearestTwo(kernels.front(), queries, database);
  for (std::size_t q = 0; q < found.size(); ++q) ExpectSame(found[q], expected[q]);
}

TEST(DescriptorAngle, IsTheAngleBetweenUnitVectors) {
  EXPECT_DOUBLE_EQ(DescriptorAngle(512 * 512), 0);
  EXPECT_DOUBLE_EQ(DescriptorAngle(512 * 512 + 5000), 0) << "rounding may exceed one";
  EXPECT_DOUBLE_EQ(DescriptorAngle(0), std::numbers::pi / 2);
  EXPECT_NEAR(DescriptorAngle(512 * 256), std::numbers::pi / 3, 1e-12);
}

TEST(MatchDescriptors, FindsPlantedCorrespondences) {
  std::mt19937 random(6);
  const auto first = RandomRootSift(400, random);
  auto second = RandomRootSift(500, random);
  std::vector<FeatureMatch> planted;
  for (std::uint32_t i = 0; i < 150; ++i) {
    planted.push_back({.first = 2 * i, .second = 499 - 3 * i});
    second[planted.back().second] = Disturbed(first[planted.back().first], 6, random);
  }
  EXPECT_EQ(MatchDescriptors(first, second, {}), planted);

  std::vector<FeatureMatch> reversed;
  for (const FeatureMatch& match : planted) reversed.push_back({match.second, match.first});
  std::ranges::sort(reversed);
  EXPECT_EQ(MatchDescriptors(second, first, {}), reversed);
}

TEST(MatchDescriptors, AmbiguousOnesAreLeftOut) {
  std::mt19937 random(7);
  const auto first = RandomRootSift(1, random);
  std::vector<Descriptor> second = {Disturbed(first[0], 6, random), Disturbed(first[0], 6, random)};
  EXPECT_THAT(MatchDescriptors(first, second, {}), IsEmpty());
  EXPECT_THAT(MatchDescriptors(first, second, {.max_ratio = 1, .mutual = false}),
              testing::SizeIs(1));
  second.pop_back();
  EXPECT_THAT(MatchDescriptors(first, second, {}), ElementsAre(FeatureMatch{0, 0}));
}

TEST(MatchDescriptors, OneToOneWhenMutual) {
  std::mt19937 random(8);
  const auto second = RandomRootSift(50, random);
  const std::vector<Descriptor> first = {Disturbed(second[20], 12, random), second[20]};
  EXPECT_THAT(MatchDescriptors(first, second, {.mutual = false}),
              ElementsAre(FeatureMatch{0, 20}, FeatureMatch{1, 20}));
  EXPECT_THAT(MatchDescriptors(first, second, {}), ElementsAre(FeatureMatch{1, 20}));
}

TEST(MatchDescriptors, FarOnesAreLeftOut) {
  std::mt19937 random(9);
  const auto first = RandomRootSift(20, random), second = RandomRootSift(1, random);
  const double angle_rad = DescriptorAngle(FindNearestTwo(second, first)[0].first_dot);
  const MatchOptions near{.max_ratio = 1, .max_angle_rad = angle_rad - 1e-6};
  const MatchOptions far{.max_ratio = 1, .max_angle_rad = angle_rad + 1e-6};
  EXPECT_THAT(MatchDescriptors(second, first, near), IsEmpty());
  EXPECT_THAT(MatchDescriptors(second, first, far), testing::SizeIs(1));
}

TEST(MatchDescriptors, NothingMatchesNothing) {
  std::mt19937 random(10);
  const auto some = RandomRootSift(10, random);
  EXPECT_THAT(MatchDescriptors({}, {}, {}), IsEmpty());
  EXPECT_THAT(MatchDescriptors(some, {}, {}), IsEmpty());
  EXPECT_THAT(MatchDescriptors({}, some, {}), IsEmpty());
}

TEST(MatchOptions, RefusesWhatIsOutOfRange) {
  EXPECT_TRUE(MatchOptions{}.Validate().ok());
  for (const MatchOptions& options :
       {MatchOptions{.max_ratio = 0}, MatchOptions{.max_ratio = 1.1},
        MatchOptions{.max_ratio = std::nan("")}, MatchOptions{.max_angle_rad = 0},
        MatchOptions{.max_angle_rad = 4}}) {
    ASSERT_FALSE(options.Validate().ok());
    EXPECT_EQ(options.Validate().error().code, ErrorCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace waymark::mapping
