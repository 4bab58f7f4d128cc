// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "localiser/internal/packed_descriptors.h"

namespace waymark::localiser::internal {

/// One way to scan groups. All give identical results on every input.
struct GroupKernel {
  std::string_view name;
  void (*meet)(std::span<const DescriptorGroup> groups, std::int32_t first_group,
               std::span<const PackedQuery> queries, std::span<const std::uint32_t> chosen,
               std::span<LaneBest> states);
  void (*dots)(std::span<const DescriptorGroup> groups, std::span<const PackedQuery> queries,
               std::int32_t* dots);
  /// Writes the indices of those that reach the bound, in order, and returns how many there are.
  /// Shapes: room for kGroupLanes more than all.
  std::size_t (*at_least)(std::span<const std::int32_t> dots, std::int32_t bound,
                          std::uint32_t* indices);
};

/// Those that this processor can run, fastest first; the last is the portable one.
std::span<const GroupKernel> SupportedGroupKernels();

// Only for the list above: ends the process where the instructions are missing.
extern const GroupKernel kVnniGroupKernel;
extern const GroupKernel kPortableGroupKernel;

}  // namespace waymark::localiser::internal
