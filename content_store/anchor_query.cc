// SPDX-License-Identifier: Apache-2.0
#include "content_store/anchor_query.h"

#include <cmath>

#include "content_store/internal/query_match.h"

namespace waymark::content {
namespace {

constexpr std::size_t kMaxPage = 1000;  // with payloads of 64 KiB that is 64 MB

Result<void> ValidateArea(const GeoCircle& circle) {
  WAYMARK_TRY(circle.centre.Validate());
  if (std::isfinite(circle.radius_m) && circle.radius_m >= 0) return {};
  return MakeError(ErrorCode::kInvalidArgument, "radius: expected at least 0 m, found {}",
                   circle.radius_m);
}

Result<void> ValidateArea(const GeoBox& box) {
  WAYMARK_TRY((GeoPoint{.latitude = box.south, .longitude = box.west}).Validate());
  WAYMARK_TRY((GeoPoint{.latitude = box.north, .longitude = box.east}).Validate());
  if (box.south.radians() <= box.north.radians()) return {};
  return MakeError(ErrorCode::kInvalidArgument,
                   "box: expected its south below its north, found {} and {} degrees",
                   box.south.degrees(), box.north.degrees());
}

Result<void> ValidateArea(std::monostate) { return {}; }

bool IsInside(const GeoCircle& circle, const GeoPoint& place) {
  return GeodesicDistance(circle.centre, place) <= circle.radius_m;
}

bool IsInside(const GeoBox& box, const GeoPoint& place) {
  const double longitude = place.longitude.radians();
  const bool is_east_of_west = longitude >= box.west.radians();
  const bool is_west_of_east = longitude <= box.east.radians();
  const bool crosses_date_line = box.west.radians() > box.east.radians();
  return place.latitude.radians() >= box.south.radians() &&
         place.latitude.radians() <= box.north.radians() &&
         (crosses_date_line ? is_east_of_west || is_west_of_east
                            : is_east_of_west && is_west_of_east);
}

bool IsInside(std::monostate, const GeoPoint&) { return true; }

}  // namespace

Result<void> AnchorQuery::Validate() const {
  WAYMARK_TRY(std::visit([](const auto& shape) { return ValidateArea(shape); }, area));
  if (limit >= 1 && limit <= kMaxPage) return {};
  return MakeError(ErrorCode::kInvalidArgument, "query limit: expected 1 to {}, found {}", kMaxPage,
                   limit);
}

namespace internal {

bool Matches(const AnchorQuery& query, const AnchorRecord& record) {
  const bool is_in_reach =
      query.room ? record.room == *query.room : record.visibility == AnchorVisibility::kPublic;
  if (!is_in_reach) return false;
  if (query.changed && (record.changed_utc_ms < query.changed->from_utc_ms ||
                        record.changed_utc_ms >= query.changed->until_utc_ms)) {
    return false;
  }
  if (query.viewer && record.visibility == AnchorVisibility::kPrivate &&
      record.owner != *query.viewer) {
    return false;
  }
  return std::visit([&](const auto& shape) { return IsInside(shape, record.place); }, query.area);
}

}  // namespace internal
}  // namespace waymark::content
