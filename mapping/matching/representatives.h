// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/features/features.h"

namespace waymark::mapping {

struct RepresentativeOptions {
  std::size_t max_count = 3;  ///< >= 1
  /// A further one must bring the descriptors that much nearer to one of them on average, radians.
  double min_gain_rad = 0.04;
};

/// Some of several descriptors of one thing that stand for all: first the one that is nearest to the
/// others, then those that help most, in this order. At least one. Deterministic.
/// Shapes: at least one descriptor. Time: grows with the square of their number.
std::vector<std::uint32_t> ChooseRepresentatives(std::span<const Descriptor> descriptors,
                                                 const RepresentativeOptions& options);

}  // namespace waymark::mapping
