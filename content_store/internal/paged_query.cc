// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/paged_query.h"

#include <algorithm>
#include <utility>

#include "content_store/internal/cell_index.h"
#include "content_store/internal/query_match.h"
#include "content_store/internal/rough_distance.h"

namespace waymark::content::internal {
namespace {

constexpr std::size_t kChunk = 256;  // old states held at once

using Found = std::vector<std::pair<Position, AnchorRecord>>;

CellRanges RangesOf(const AnchorQuery& query) {
  if (const auto* circle = std::get_if<GeoCircle>(&query.area)) {
    return CoverCircle({circle->centre.latitude.radians(), circle->centre.longitude.radians()},
                       circle->radius_m);
  }
  if (const auto* box = std::get_if<GeoBox>(&query.area)) {
    return CoverBox({box->south.radians(), box->west.radians()},
                    {box->north.radians(), box->east.radians()});
  }
  constexpr auto kAll = std::numeric_limits<std::int64_t>();
  return {{kAll.min(), kAll.max()}};
}

class PageSearch {
 public:
  PageSearch(AnchorTables& tables, const AnchorQuery& query, std::uint64_t as_of)
      : tables_(tables), query_(query), as_of_(as_of) {
    const bool is_by_time =
        query.room && query.changed && std::holds_alternative<std::monostate>(query.area);
    order_ = is_by_time ? ScanOrder::kChanged : ScanOrder::kCell;
    if (query.after) after_ = {query.after->key, query.after->revision};
  }

  Result<AnchorPage> Run(std::uint64_t latest) {
    Found found;
    WAYMARK_TRY(SearchIndex(found));
    if (latest > as_of_) WAYMARK_TRY(SearchReplaced(found));
    Keep(found, query_.limit + 1);
    AnchorPage page{.revision = as_of_, .anchors = {}, .next = std::nullopt};
    if (found.size() > query_.limit) {
      found.pop_back();
      page.next = {as_of_, found.back().first.key, found.back().first.revision};
    }
    for (auto& [position, record] : found) page.anchors.push_back(std::move(record));
    return page;
  }

 private:
  /// The first `limit + 1` matches that have not changed since.
  Result<void> SearchIndex(Found& found) {
    CellRanges ranges{};
    if (order_ == ScanOrder::kCell) {
      ranges = RangesOf(query_);
    } else if (query_.changed->from_utc_ms < query_.changed->until_utc_ms) {
      ranges = {{query_.changed->from_utc_ms, query_.changed->until_utc_ms - 1}};
    }
    Scan scan{.order = order_,
              .room = query_.room,
              .ranges = std::move(ranges),
              .newest = as_of_,
              .after = after_,
              .limit = query_.limit + 1};
    for (bool is_more = true; is_more && found.size() <= query_.limit;) {
      const std::vector<Position> positions = tables_.FindPlaces(scan);
      is_more = positions.size() == scan.limit;
      if (is_more) scan.after = positions.back();
      WAYMARK_TRY(AddMatches(positions, found));
    }
    return {};
  }

  Result<void> AddMatches(const std::vector<Position>& positions, Found& found) {
    std::vector<std::uint64_t> revisions;
    std::vector<Position> likely;
    for (const Position& position : positions) {
      if (!MayMatch(position)) continue;
      likely.push_back(position);
      revisions.push_back(position.revision);
    }
    WAYMARK_TRY_ASSIGN(auto records, LoadLive(tables_, query_.room, revisions));
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (Matches(query_, records[i])) found.emplace_back(likely[i], std::move(records[i]));
    }
    return {};
  }

  /// Tells most anchors in a circle's covering but out of the circle without reading them.
  bool MayMatch(const Position& position) const {
    const auto* circle = std::get_if<GeoCircle>(&query_.area);
    if (circle == nullptr) return true;
    const CellPlace middle{circle->centre.latitude.radians(), circle->centre.longitude.radians()};
    return RoughDistance(middle, CentreOf(position.key)) <= LargestRough(circle->radius_m);
  }

  /// Matches among what changed since, in the states of then.
  Result<void> SearchReplaced(Found& found) {
    const auto replaced = tables_.FindReplaced(query_.room, as_of_, kMaxReplaced + 1);
    if (replaced.size() > kMaxReplaced) {
      return MakeError(ErrorCode::kConflict,
                       "{}: query at revision {}: more than {} anchors changed since; begin again",
                       tables_.name(), as_of_, kMaxReplaced);
    }
    for (std::size_t begin = 0; begin < replaced.size(); begin += kChunk) {
      const std::size_t end = std::min(begin + kChunk, replaced.size());
      WAYMARK_TRY_ASSIGN(auto states,
                         LoadVerified(tables_, {replaced.begin() + std::ptrdiff_t(begin),
                                                replaced.begin() + std::ptrdiff_t(end)}));
      for (AnchorState& state : states) {
        if (state.is_deleted || !Matches(query_, state.record)) continue;
        const PlaceRow place = ToPlaceRow(state);
        const Position position{order_ == ScanOrder::kCell ? *place.cell : *place.changed,
                                place.revision};
        if (position > after_) found.emplace_back(position, std::move(state.record));
      }
      Keep(found, query_.limit + 1);
    }
    return {};
  }

  static void Keep(Found& found, std::size_t count) {
    std::sort(found.begin(), found.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    if (found.size() > count) found.erase(found.begin() + std::ptrdiff_t(count), found.end());
  }

  AnchorTables& tables_;
  const AnchorQuery& query_;
  const std::uint64_t as_of_;
  ScanOrder order_ = ScanOrder::kCell;
  Position after_;
};

}  // namespace

Result<AnchorPage> FindPage(AnchorTables& tables, const AnchorQuery& query) {
  const std::uint64_t latest = tables.LatestRevision();
  const std::uint64_t as_of = query.after ? query.after->as_of : latest;
  if (as_of > latest) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "query: expected a position up to revision {}, found {}", latest, as_of);
  }
  if (as_of < latest && as_of < tables.LoadCompaction().through) {
    return MakeError(ErrorCode::kConflict,
                     "{}: query at revision {}: the store was compacted since; begin again",
                     tables.name(), as_of);
  }
  return PageSearch(tables, query, as_of).Run(latest);
}

}  // namespace waymark::content::internal
