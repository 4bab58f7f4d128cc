// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/nearest.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <tuple>
#include <utility>

#include "content_store/internal/cell_index.h"
#include "content_store/internal/rough_distance.h"

namespace waymark::content::internal {
namespace {

constexpr double kFirstRadius_m = 250;
constexpr std::size_t kScanned = 4096;  // index rows held at once

struct Hint {
  double distance_m;  // rough: of the anchor's cell, on the sphere
  std::uint64_t revision;
  friend auto operator<=>(const Hint&, const Hint&) = default;
};

/// Drops hints that cannot be among the `limit` nearest.
void Trim(std::vector<Hint>& hints, std::size_t limit) {
  std::sort(hints.begin(), hints.end());
  if (hints.size() <= limit) return;
  // `limit` anchors are this near in truth, so farther ones are out.
  const double nearest_m = LargestTrue(hints[limit - 1].distance_m);
  hints.erase(
      std::find_if(hints.begin(), hints.end(),
                   [&](const Hint& hint) { return hint.distance_m > LargestRough(nearest_m); }),
      hints.end());
}

/// All anchors that the answer may hold, by rough distance.
std::vector<Hint> FindHints(AnchorTables& tables, const RoomId& room, const CellPlace& middle,
                            double radius_m, std::size_t limit) {
  std::vector<Hint> hints;
  std::size_t trim_at = std::min<std::size_t>(limit, 1'000'000'000) * 2 + kScanned;
  Scan scan{.order = ScanOrder::kCell,
            .room = room,
            .ranges = CoverCircle(middle, radius_m),
            .newest = std::numeric_limits<std::uint64_t>::max(),
            .after = {},
            .limit = kScanned};
  for (bool is_more = true; is_more;) {
    const std::vector<Position> found = tables.FindPlaces(scan);
    is_more = found.size() == scan.limit;
    if (is_more) scan.after = found.back();
    for (const Position& position : found) {
      const double distance_m = RoughDistance(middle, CentreOf(position.key));
      if (distance_m <= LargestRough(radius_m)) hints.push_back({distance_m, position.revision});
    }
    if (hints.size() > trim_at) {
      Trim(hints, limit);
      trim_at = 2 * hints.size() + kScanned;
    }
  }
  Trim(hints, limit);
  return hints;
}

}  // namespace

Result<std::vector<AnchorRecord>> FindNearest(AnchorTables& tables, const RoomId& room,
                                              const GeoPoint& centre, double radius_m,
                                              std::size_t limit) {
  const CellPlace middle{centre.latitude.radians(), centre.longitude.radians()};
  // In growing circles, so that a few neighbours cost no look at the whole room.
  double reach_m = std::min(radius_m, kFirstRadius_m);
  std::vector<Hint> hints = FindHints(tables, room, middle, reach_m, limit);
  while (reach_m < radius_m &&
         (hints.size() < limit || LargestTrue(hints[limit - 1].distance_m) > reach_m)) {
    reach_m = std::min(radius_m, 4 * reach_m);
    hints = FindHints(tables, room, middle, reach_m, limit);
  }
  std::vector<std::uint64_t> revisions;
  for (const Hint& hint : hints) revisions.push_back(hint.revision);
  WAYMARK_TRY_ASSIGN(auto records, LoadLive(tables, room, revisions));
  std::vector<std::pair<double, AnchorRecord>> near;
  for (AnchorRecord& record : records) {
    const double distance_m = GeodesicDistance(centre, record.place);
    if (distance_m <= radius_m) near.emplace_back(distance_m, std::move(record));
  }
  std::sort(near.begin(), near.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first, a.second.id) < std::tie(b.first, b.second.id);
  });
  records.clear();
  for (auto& [distance_m, record] : near) {
    if (records.size() < limit) records.push_back(std::move(record));
  }
  return records;
}

}  // namespace waymark::content::internal
