// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "content_store/anchor_store.h"

namespace waymark::content {

struct ExportReport {
  std::uint64_t revision = 0;
  std::size_t anchors = 0;
};

/// Writes all live anchors of a room, or of all rooms, as they were at one revision, as GeoJSON,
/// one feature a line. Holds one page at a time. Spent ids and older states are not in it.
/// Errors: those of AnchorStore::Query; Unavailable when the stream fails.
Result<ExportReport> ExportGeoJson(AnchorStore& store, const std::optional<RoomId>& room,
                                   std::ostream& out);

/// What becomes of an anchor that is there already and differs.
enum class OnDifference { kKeep, kReplace };

struct ImportOptions {
  std::optional<RoomId> room{};  ///< all go into this one; absent: each into its own
  OnDifference on_difference = OnDifference::kKeep;
};

struct ImportReport {
  std::size_t created = 0;
  std::size_t unchanged = 0;  ///< were there already
  std::size_t replaced = 0;
  std::size_t kept = 0;               ///< were there and differ, or their id is spent
  std::vector<std::string> examples;  ///< of what was kept and why; at most 10
};

/// Creates the anchors of a GeoJSON that ExportGeoJson or EncodeGeoJson wrote. Ids and times stay;
/// revisions are the store's. May be repeated. Ends at the first feature that is invalid; what came
/// before it is there. Errors: InvalidArgument, and those of AnchorStore.
Result<ImportReport> ImportGeoJson(AnchorStore& store, std::istream& in,
                                   const ImportOptions& options);

}  // namespace waymark::content
