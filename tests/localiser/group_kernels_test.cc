// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/group_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <vector>

#include "localiser/internal/top_cells.h"
#include "tests/localiser/random_place.h"

namespace waymark::localiser::internal {
namespace {

std::vector<mapping::Descriptor> MakeDescriptors(int landmarks) {
  std::vector<mapping::Descriptor> descriptors;
  for (const auto& seen : RandomPlace({.landmarks = landmarks}, 9).Model().observations) {
    descriptors.push_back(seen.descriptor);
  }
  return descriptors;
}

/// Groups of some entries, in order.
std::vector<DescriptorGroup> Pack(std::span<const mapping::Descriptor> entries) {
  std::vector<DescriptorGroup> groups((entries.size() + kGroupLanes - 1) / kGroupLanes,
                                      EmptyGroup());
  for (std::size_t e = 0; e < entries.size(); ++e) {
    PackInto(entries[e], e % kGroupLanes, groups[e / kGroupLanes]);
  }
  return groups;
}

/// Groups of which the last is not full, and queries of which some are extreme. Every count of
/// groups and queries up to these is another choice of tiles.
class GroupKernels : public testing::Test {
 protected:
  GroupKernels() : entries_(MakeDescriptors(75)), queries_(MakeDescriptors(3)) {
    entries_.resize(15 * kGroupLanes - 5);
    entries_[7].fill(255);
    queries_.front().fill(255);
    queries_.back().fill(0);
  }

  std::int32_t Dot(std::size_t query, std::size_t entry) const {
    if (entry >= entries_.size()) return 0;
    return std::inner_product(queries_[query].begin(), queries_[query].end(),
                              entries_[entry].begin(), 0);
  }

  std::vector<mapping::Descriptor> entries_, queries_;
};

TEST_F(GroupKernels, GiveDotProducts) {
  const auto groups = Pack(entries_);
  const std::vector<PackedQuery> queries(queries_.begin(), queries_.end());
  for (const GroupKernel& kernel : SupportedGroupKernels()) {
    for (std::size_t g = 1; g <= groups.size(); ++g) {
      const std::size_t row = g * kGroupLanes;
      std::vector<std::int32_t> dots(queries.size() * row);
      kernel.dots(std::span(groups).first(g), queries, dots.data());
      for (std::size_t i = 0; i < dots.size(); ++i) {
        ASSERT_EQ(dots[i], Dot(i / row, i % row)) << kernel.name << ", " << g << " groups";
      }
    }
  }
}

TEST_F(GroupKernels, KeepTheBestTwoOfEachLane) {
  const auto groups = Pack(entries_);
  const std::vector<PackedQuery> queries(queries_.begin(), queries_.end());
  for (const GroupKernel& kernel : SupportedGroupKernels()) {
    for (std::size_t count = 1; count <= queries.size(); ++count) {
      std::vector<std::uint32_t> chosen(count);
      std::iota(chosen.rbegin(), chosen.rend(), 0U);
      std::vector<LaneBest> states(queries.size());
      for (LaneBest& state : states) state.Clear();
      const std::size_t met = 1 + count % groups.size();
      kernel.meet(std::span(groups).first(met), 100, queries, chosen, states);
      kernel.meet(std::span(groups).subspan(met), 100 + static_cast<std::int32_t>(met), queries,
                  chosen, states);
      for (std::size_t q = 0; q < count; ++q) {
        for (std::size_t lane = 0; lane < kGroupLanes; ++lane) {
          std::vector<std::size_t> order(groups.size());
          std::iota(order.begin(), order.end(), 0U);
          const auto dot = [&](std::size_t group) { return Dot(q, group * kGroupLanes + lane); };
          std::ranges::stable_sort(order, std::greater<>(), dot);
          ASSERT_EQ(states[q].first_dot[lane], dot(order[0])) << kernel.name;
          ASSERT_EQ(states[q].second_dot[lane], dot(order[1])) << kernel.name;
          ASSERT_EQ(states[q].first_group[lane], 100 + order[0]) << kernel.name;
          ASSERT_EQ(states[q].second_group[lane], 100 + order[1]) << kernel.name;
        }
      }
    }
  }
}

TEST(TopCells, AreThoseOfAWholeSort) {
  std::vector<std::int32_t> dots(1000);
  for (std::size_t i = 0; i < dots.size(); ++i) dots[i] = static_cast<int>(i * 7919 % 331) - 5;
  for (const std::size_t cells : {1u, 5u, 63u, 64u, 255u, 256u, 257u, 999u, 1000u}) {
    for (const std::size_t wanted : {1u, 16u, 64u, 65u}) {
      if (wanted > cells) continue;
      std::vector<std::uint32_t> order(cells);
      std::iota(order.begin(), order.end(), 0U);
      std::ranges::stable_sort(order, std::greater<>(), [&](std::uint32_t c) { return dots[c]; });
      order.resize(wanted);
      std::vector<std::uint32_t> chosen;
      TopCells(cells, wanted).AppendTo(std::span(dots).first(cells), chosen);
      EXPECT_EQ(chosen, order) << wanted << " of " << cells;
    }
  }
}

}  // namespace
}  // namespace waymark::localiser::internal
