// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/cell_index.h"

#include <s2/s2cap.h>
#include <s2/s2cell_id.h>
#include <s2/s2cell_union.h>
#include <s2/s2latlng.h>
#include <s2/s2latlng_rect.h>
#include <s2/s2region_coverer.h>

#include <algorithm>
#include <numbers>

namespace waymark::content::internal {
namespace {

// S2 puts geodetic coordinates on a sphere. A metre on the ellipsoid turns them most where the
// meridian is bent most, at the equator: a (1 - e^2).
constexpr double kSmallestCurvatureRadius_m = 6335439.0;

S2LatLng ToLatLng(const CellPlace& place) {
  return S2LatLng::FromRadians(place.latitude_rad, place.longitude_rad).Normalized();
}

CellRanges Cover(const S2Region& region) {
  S2RegionCoverer::Options options;
  options.set_max_cells(8);
  options.set_max_level(18);  // about 38 m: finer cells cost more ranges than they spare rows
  S2RegionCoverer coverer(options);
  std::vector<S2CellId> cells;
  coverer.GetCovering(region, &cells);
  CellRanges ranges;
  for (const S2CellId cell : cells) {
    ranges.emplace_back(static_cast<std::int64_t>(cell.range_min().id()),
                        static_cast<std::int64_t>(cell.range_max().id()));
  }
  std::sort(ranges.begin(), ranges.end());
  return ranges;
}

}  // namespace

std::int64_t CellOf(const CellPlace& place) {
  return static_cast<std::int64_t>(S2CellId(ToLatLng(place)).id());
}

CellPlace CentreOf(std::int64_t cell) {
  const S2CellId id(static_cast<std::uint64_t>(cell));
  if (!id.is_valid()) return {0, 0};
  const S2LatLng centre = id.ToLatLng();
  return {centre.lat().radians(), centre.lng().radians()};
}

CellRanges CoverCircle(const CellPlace& centre, double radius_m) {
  const double angle_rad = std::min(
      std::numbers::pi, (radius_m + 2 * kCellError_m) * (1 + 1e-9) / kSmallestCurvatureRadius_m);
  return Cover(S2Cap(ToLatLng(centre).ToPoint(), S1Angle::Radians(angle_rad)));
}

CellRanges CoverBox(const CellPlace& south_west, const CellPlace& north_east) {
  const double width_rad = north_east.longitude_rad - south_west.longitude_rad;
  const bool is_all_round = width_rad >= 2 * std::numbers::pi;
  const S2LatLngRect box(R1Interval(south_west.latitude_rad, north_east.latitude_rad),
                         is_all_round
                             ? S1Interval::Full()
                             : S1Interval(std::max(-std::numbers::pi, south_west.longitude_rad),
                                          std::min(std::numbers::pi, north_east.longitude_rad)));
  // A leaf cell's width around, so that a place on the rim is in whatever its rounding did.
  const double margin_rad = 2 * kCellError_m / kSmallestCurvatureRadius_m;
  return Cover(box.ExpandedByDistance(S1Angle::Radians(margin_rad)));
}

}  // namespace waymark::content::internal
