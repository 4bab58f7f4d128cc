// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/internal/descriptor_cells.h"

#include <algorithm>
#include <numeric>

#include "mapping/matching/internal/nearest_two_kernels.h"

namespace waymark::mapping::internal {
namespace {

/// The search kernel knows the best of many, not the best few. So centres lie in groups of one wide
/// register, and the best few of the groups' best are taken: two centres of one group that are
/// both among the nearest are rare, and the next nearest then takes the place.
constexpr std::size_t kGroup = 16;

/// Items by key, and where each key begins.
struct Buckets {
  std::vector<std::uint32_t> begins;
  std::vector<std::uint32_t> items;
};

/// Counting sort: item i has the keys from i * keys_per_item on. Items of one key keep their order.
Buckets SortIntoBuckets(std::size_t bucket_count, std::span<const std::uint32_t> keys,
                        std::size_t keys_per_item) {
  Buckets buckets{.begins = std::vector<std::uint32_t>(bucket_count + 1),
                  .items = std::vector<std::uint32_t>(keys.size())};
  for (const std::uint32_t key : keys) ++buckets.begins[key + 1];
  std::partial_sum(buckets.begins.begin(), buckets.begins.end(), buckets.begins.begin());
  std::vector<std::uint32_t> next(buckets.begins.begin(), buckets.begins.end() - 1);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    buckets.items[next[keys[i]]++] = static_cast<std::uint32_t>(i / keys_per_item);
  }
  return buckets;
}

}  // namespace

CelledDescriptors DescriptorCells::Sort(std::span<const Descriptor> descriptors,
                                        std::size_t probe_count) const {
  struct Candidate {
    std::int32_t dot;
    std::uint32_t cell;
  };
  const std::size_t group_count = (size() + kGroup - 1) / kGroup;
  std::vector<Candidate> candidates(descriptors.size() * group_count);
  for (std::size_t g = 0; g < group_count; ++g) {
    std::vector<Descriptor> group;
    for (std::size_t cell = g; cell < size(); cell += group_count) group.push_back(centres_[cell]);
    const auto nearest = mapping::FindNearestTwo(descriptors, group);
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      candidates[i * group_count + g] = {
          nearest[i].first_dot, static_cast<std::uint32_t>(nearest[i].first * group_count + g)};
    }
  }
  probe_count = std::min(probe_count, group_count);
  CelledDescriptors sorted{.probe_count = probe_count};
  std::vector<std::uint32_t> own;
  for (std::size_t i = 0; i < descriptors.size(); ++i) {
    const auto begin = candidates.begin() + static_cast<std::ptrdiff_t>(i * group_count);
    const auto end = begin + static_cast<std::ptrdiff_t>(group_count);
    std::partial_sort(begin, begin + static_cast<std::ptrdiff_t>(probe_count), end,
                      [](const Candidate& a, const Candidate& b) {
                        return a.dot != b.dot ? a.dot > b.dot : a.cell < b.cell;
                      });
    own.push_back(begin->cell);
    for (std::size_t k = 0; k < probe_count; ++k) sorted.probes.push_back(begin[k].cell);
  }
  Buckets buckets = SortIntoBuckets(size(), own, 1);
  sorted.begins = std::move(buckets.begins);
  sorted.members = std::move(buckets.items);
  return sorted;
}

std::vector<NearestTwo> DescriptorCells::FindNearestTwo(std::span<const Descriptor> queries,
                                                        const CelledDescriptors& query_cells,
                                                        std::span<const std::uint32_t> chosen,
                                                        std::span<const Descriptor> database,
                                                        const CelledDescriptors& database_cells) {
  std::vector<Descriptor> asking;
  std::vector<std::uint32_t> probes;
  const std::size_t probe_count = query_cells.probe_count;
  for (const std::uint32_t query : chosen) {
    asking.push_back(queries[query]);
    const auto begin =
        query_cells.probes.begin() + static_cast<std::ptrdiff_t>(query * probe_count);
    probes.insert(probes.end(), begin, begin + static_cast<std::ptrdiff_t>(probe_count));
  }
  const Buckets buckets = SortIntoBuckets(database_cells.begins.size() - 1, probes, probe_count);
  return SupportedNearestTwoKernels().front().find(asking, database,
                                                   {.query_begins = buckets.begins,
                                                    .queries = buckets.items,
                                                    .entry_begins = database_cells.begins,
                                                    .entries = database_cells.members});
}

}  // namespace waymark::mapping::internal
