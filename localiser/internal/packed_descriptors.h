// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/features/features.h"

namespace waymark::localiser::internal {

/// Descriptors that are scanned together lie side by side, so that a register holds the same four
/// components of all of them and nothing is ever summed across it.
inline constexpr std::size_t kGroupLanes = 16;

/// Components are stored minus 128, because the processor's instruction multiplies unsigned by
/// signed bytes. Lanes beyond the last descriptor hold zeros: similar to nothing.
struct DescriptorGroup {
  alignas(64) std::int8_t steps[32][kGroupLanes][4];
};

/// The best two entries that a query has met in each lane. Entries are counted over all groups.
struct LaneBest {
  alignas(64) std::int32_t first_dot[kGroupLanes];
  alignas(64) std::int32_t second_dot[kGroupLanes];
  alignas(64) std::int32_t first_group[kGroupLanes];  ///< -1: none yet
  alignas(64) std::int32_t second_group[kGroupLanes];

  void Clear();
};

/// A query prepared for scanning: what the missing 128s amount to.
struct PackedQuery {
  PackedQuery() = default;
  explicit PackedQuery(const mapping::Descriptor& asked);

  const mapping::Descriptor* descriptor = nullptr;  ///< borrowed
  std::int32_t offset = 0;
};

/// Where one descriptor goes. Groups begin as `EmptyGroup`.
DescriptorGroup EmptyGroup();
void PackInto(const mapping::Descriptor& descriptor, std::size_t lane, DescriptorGroup& group);

/// Makes each of the chosen queries meet every entry of some groups, the first of which is number
/// `first_group` of all. Shapes: as many states as queries; `chosen` indexes both.
/// All processors give identical results.
void MeetGroups(std::span<const DescriptorGroup> groups, std::int32_t first_group,
                std::span<const PackedQuery> queries, std::span<const std::uint32_t> chosen,
                std::span<LaneBest> states);

/// The largest dot product with an entry that is not of `landmark`; -1: there is none.
/// Shapes: kGroupLanes landmarks per group.
std::int32_t BestOfAnother(std::span<const DescriptorGroup> groups,
                           std::span<const std::uint32_t> landmarks, const PackedQuery& query,
                           std::uint32_t landmark);

/// All dot products. Shapes: a row for each query, of kGroupLanes dots per group.
void ComputeDots(std::span<const DescriptorGroup> groups, std::span<const PackedQuery> queries,
                 std::span<std::int32_t> dots);

}  // namespace waymark::localiser::internal
