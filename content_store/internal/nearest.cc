// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/nearest.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>

#include "content_store/internal/cell_index.h"

namespace waymark::content::internal {
namespace {

// Metres on WGS84 per radian of S2's sphere lie between the smallest and the largest radius of
// curvature, 6335439 and 6399594 m. The middle is off by a known part at most, either way.
constexpr double kMetresPerRadian = 6367516.5;
constexpr double kShapeError = 0.00504;

struct Hint {
  double distance_m;  // rough: of the anchor's cell, on the sphere
  std::uint64_t revision;
  friend auto operator<=>(const Hint&, const Hint&) = default;
};

/// Far cheaper than GeodesicDistance; good to kShapeError and kCellError_m.
double RoughDistance(const CellPlace& a, const CellPlace& b) {
  const double half_lat = std::sin((a.latitude_rad - b.latitude_rad) / 2);
  const double half_lon = std::sin((a.longitude_rad - b.longitude_rad) / 2);
  const double h = half_lat * half_lat +
                   std::cos(a.latitude_rad) * std::cos(b.latitude_rad) * half_lon * half_lon;
  return kMetresPerRadian * 2 * std::asin(std::sqrt(std::min(1.0, h)));
}

/// The largest rough distance of an anchor whose true distance is not larger than this.
double LargestRough(double true_m) {
  return true_m * (1 + kShapeError) / (1 - kShapeError) + 2 * kCellError_m;
}

/// All anchors that the answer may hold, by rough distance.
std::vector<Hint> FindHints(AnchorTables& tables, const RoomId& room, const GeoPoint& centre,
                            double radius_m, std::size_t limit) {
  std::vector<Hint> hints;
  const CellPlace middle{centre.latitude.radians(), centre.longitude.radians()};
  for (const auto& [first, last] : CoverCircle(middle, radius_m)) {
    for (const Candidate& candidate : tables.FindCandidates(room, first, last)) {
      const double distance_m = RoughDistance(middle, CentreOf(candidate.cell));
      if (distance_m <= LargestRough(radius_m)) hints.push_back({distance_m, candidate.revision});
    }
  }
  std::sort(hints.begin(), hints.end());
  if (hints.size() > limit) {  // `limit` anchors are this near in truth, so farther ones are out
    const double nearest_m = (hints[limit - 1].distance_m + 2 * kCellError_m) * (1 + kShapeError);
    hints.erase(
        std::find_if(hints.begin(), hints.end(),
                     [&](const Hint& hint) { return hint.distance_m > LargestRough(nearest_m); }),
        hints.end());
  }
  return hints;
}

}  // namespace

Result<std::vector<AnchorRecord>> FindNearest(AnchorTables& tables, const RoomId& room,
                                              const GeoPoint& centre, double radius_m,
                                              std::size_t limit) {
  std::vector<std::pair<double, AnchorRecord>> near;
  for (const Hint& hint : FindHints(tables, room, centre, radius_m, limit)) {
    WAYMARK_TRY_ASSIGN(auto record, tables.LoadLive(room, hint.revision));
    const double distance_m = GeodesicDistance(centre, record.place);
    if (distance_m <= radius_m) near.emplace_back(distance_m, std::move(record));
  }
  std::sort(near.begin(), near.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first, a.second.id) < std::tie(b.first, b.second.id);
  });
  std::vector<AnchorRecord> records;
  for (auto& [distance_m, record] : near) {
    if (records.size() < limit) records.push_back(std::move(record));
  }
  return records;
}

}  // namespace waymark::content::internal
