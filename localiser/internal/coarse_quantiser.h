// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/features/features.h"

namespace waymark::localiser::internal {

/// Representatives of a set of descriptors, themselves of a descriptor's length: the cells that a
/// search visits are those of the most similar representatives. At most `count`, at least 1.
/// Deterministic for a seed as long as no other thread calls std::rand meanwhile.
/// Shapes: at least one descriptor.
std::vector<mapping::Descriptor> TrainCoarseQuantiser(
    std::span<const mapping::Descriptor> descriptors, std::size_t count, std::uint64_t seed);

}  // namespace waymark::localiser::internal
