// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "mapping/matching/descriptor_matching.h"

namespace waymark::mapping::internal {

/// The chosen database entry, if it is near enough and clearly nearer than the second nearest.
/// Source: Lowe 2004, section 7.1, on angles.
inline std::optional<std::uint32_t> Choose(const NearestTwo& nearest, const MatchOptions& options) {
  if (nearest.first_dot < 0) return std::nullopt;
  const double angle_rad = DescriptorAngle(nearest.first_dot);
  if (angle_rad > options.max_angle_rad) return std::nullopt;
  // A lone candidate competes with an unrelated one.
  const double second_angle_rad = DescriptorAngle(std::max(nearest.second_dot, 0));
  if (angle_rad >= options.max_ratio * second_angle_rad) return std::nullopt;
  return nearest.first;
}

}  // namespace waymark::mapping::internal
