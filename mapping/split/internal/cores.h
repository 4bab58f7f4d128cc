// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapping/split/internal/enclosing_circle.h"
#include "mapping/split/split.h"

namespace waymark::mapping {

/// The images that one subset owns, with the smallest circle around them.
struct Core {
  std::vector<std::uint32_t> images;  ///< indices into the positions, ascending
  Circle circle;
};

/// The circle of the subset that grows from a core.
Circle SubsetCircle(const Core& core, const SplitOptions& options);

/// The same circle, widened to at most twice its size where fewer than `min_shared_images`
/// positions of other cores lie in it: sparse neighbours must share images too.
Circle SharingCircle(std::span<const Eigen::Vector2d> positions, const Core& core,
                     const SplitOptions& options);

/// Partitions all positions into cores by the greedy sweep, then joins cores that are too small
/// to their best neighbour.
std::vector<Core> SweepCores(std::span<const Eigen::Vector2d> positions,
                             const SplitOptions& options);

}  // namespace waymark::mapping
