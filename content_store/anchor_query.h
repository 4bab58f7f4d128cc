// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "content_store/anchor_record.h"
#include "mapping/base/result.h"

namespace waymark::content {

/// All places within a ground distance, heights ignored; the rim belongs to it.
struct GeoCircle {
  GeoPoint centre;
  double radius_m = 0;
};

/// All places between two parallels and two meridians, which belong to it. From west eastwards to
/// east: a box with west > east crosses the date line.
struct GeoBox {
  Angle south, west, north, east;
};

/// Instants, the end not included.
struct TimeSpan {
  std::int64_t from_utc_ms = std::numeric_limits<std::int64_t>::min();
  std::int64_t until_utc_ms = std::numeric_limits<std::int64_t>::max();
};

/// Where the next page of an answer begins. Opaque: comes from AnchorPage, goes into AnchorQuery.
struct QueryPosition {
  std::uint64_t as_of = 0;  ///< revision of the first page
  std::int64_t key = 0;
  std::uint64_t revision = 0;
};

/// Which anchors are wanted; what is absent does not narrow the answer.
struct AnchorQuery {
  std::optional<RoomId> room{};  ///< absent: the public anchors of all rooms
  std::variant<std::monostate, GeoCircle, GeoBox> area{};
  std::optional<TimeSpan> changed{};     ///< by changed_utc_ms
  std::optional<std::string> viewer{};   ///< an owner: private anchors of others are left out
  std::size_t limit = 100;               ///< [1, 1000]; of one page
  std::optional<QueryPosition> after{};  ///< the page before's `next`

  /// Errors: InvalidArgument naming the field.
  Result<void> Validate() const;
};

/// A part of an answer. The pages of one query together are its answer at `revision`, whatever is
/// written between them: no anchor twice, none missing, none in a later state.
struct AnchorPage {
  std::uint64_t revision = 0;  ///< of the first page
  std::vector<AnchorRecord> anchors;
  std::optional<QueryPosition> next;  ///< absent: this was the last page
};

}  // namespace waymark::content
