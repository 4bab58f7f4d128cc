// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <compare>
#include <cstdint>

namespace waymark::session {

/// A square of the map seen from above.
struct MapCell {
  std::int32_t east = 0;  ///< its west side is at `east` times the side's length
  std::int32_t north = 0;

  auto operator<=>(const MapCell&) const = default;
};

/// The side's length: about what one submap shows.
inline constexpr double kCellSide_m = 50;

inline MapCell CellOf(const Eigen::Vector3d& map_position) {
  return {static_cast<std::int32_t>(std::floor(map_position.x() / kCellSide_m)),
          static_cast<std::int32_t>(std::floor(map_position.y() / kCellSide_m))};
}

}  // namespace waymark::session
