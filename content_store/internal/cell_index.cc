// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/cell_index.h"

#include <s2/s2cap.h>
#include <s2/s2cell_id.h>
#include <s2/s2cell_union.h>
#include <s2/s2latlng.h>
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

std::vector<std::pair<std::int64_t, std::int64_t>> CoverCircle(const CellPlace& centre,
                                                               double radius_m) {
  const double angle_rad = std::min(
      std::numbers::pi, (radius_m + 2 * kCellError_m) * (1 + 1e-9) / kSmallestCurvatureRadius_m);
  S2RegionCoverer::Options options;
  options.set_max_cells(8);
  options.set_max_level(18);  // about 38 m: finer cells cost more ranges than they spare rows
  S2RegionCoverer coverer(options);
  std::vector<S2CellId> cells;
  coverer.GetCovering(S2Cap(ToLatLng(centre).ToPoint(), S1Angle::Radians(angle_rad)), &cells);
  std::vector<std::pair<std::int64_t, std::int64_t>> ranges;
  for (const S2CellId cell : cells) {
    ranges.emplace_back(static_cast<std::int64_t>(cell.range_min().id()),
                        static_cast<std::int64_t>(cell.range_max().id()));
  }
  return ranges;
}

}  // namespace waymark::content::internal
