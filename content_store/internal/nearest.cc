// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/nearest.h"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>

#include "content_store/internal/cell_index.h"

namespace waymark::content::internal {
namespace {

constexpr double kSlack_m = 2 * kCellError_m;

struct Hint {
  double distance_m;  // of the anchor's cell
  std::uint64_t revision;
  friend auto operator<=>(const Hint&, const Hint&) = default;
};

GeoPoint PlaceOf(std::int64_t cell) {
  const CellPlace place = CentreOf(cell);
  return {.latitude = Angle::Radians(place.latitude_rad),
          .longitude = Angle::Radians(place.longitude_rad),
          .ellipsoid_height_m = 0};
}

/// All anchors that the answer may hold, by the distance of their cells.
std::vector<Hint> FindHints(AnchorTables& tables, const RoomId& room, const GeoPoint& centre,
                            double radius_m, std::size_t limit) {
  std::vector<Hint> hints;
  const CellPlace middle{centre.latitude.radians(), centre.longitude.radians()};
  for (const auto& [first, last] : CoverCircle(middle, radius_m)) {
    for (const Candidate& candidate : tables.FindCandidates(room, first, last)) {
      const double distance_m = GeodesicDistance(centre, PlaceOf(candidate.cell));
      if (distance_m <= radius_m + kSlack_m) hints.push_back({distance_m, candidate.revision});
    }
  }
  std::sort(hints.begin(), hints.end());
  if (hints.size() > limit) {
    const double last_m = hints[limit - 1].distance_m + kSlack_m;
    hints.erase(std::find_if(hints.begin(), hints.end(),
                             [&](const Hint& hint) { return hint.distance_m > last_m; }),
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
