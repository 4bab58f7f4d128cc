// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "mapping/features/features.h"

namespace waymark::localiser::internal {

/// The dot product of one descriptor with each of many; shapes: as many dots as entries. Compiled
/// for several processors, chosen at run time; all give identical results.
void ComputeDots(const mapping::Descriptor& query, std::span<const mapping::Descriptor> entries,
                 std::span<std::int32_t> dots);

}  // namespace waymark::localiser::internal
