// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

// Only plain numbers here: S2's headers define CHECK, ours do too, so they must not meet.
namespace waymark::content::internal {

/// Latitude and longitude, radians.
struct CellPlace {
  double latitude_rad;
  double longitude_rad;
};

/// The S2 leaf cell (about 1 cm wide) of a place, as the signed number that SQL stores. Cells of
/// one covering range stay neighbours under the sign.
std::int64_t CellOf(const CellPlace& place);

/// The middle of a leaf cell, within kCellError_m of every place that maps to it.
CellPlace CentreOf(std::int64_t cell);
inline constexpr double kCellError_m = 0.02;

using CellRanges = std::vector<std::pair<std::int64_t, std::int64_t>>;

/// Inclusive ranges, ascending, that together hold the cell of every place within a ground distance
/// on WGS84, and of some farther ones.
CellRanges CoverCircle(const CellPlace& centre, double radius_m);

/// The same for a box from its south-western corner eastwards to its north-eastern one.
CellRanges CoverBox(const CellPlace& south_west, const CellPlace& north_east);

}  // namespace waymark::content::internal
