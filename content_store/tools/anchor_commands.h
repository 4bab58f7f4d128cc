// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mapping/base/result.h"

/// What waymark-anchors does, one function per command; each returns an exit status.
namespace waymark::content {

struct ToolArguments {
  std::string store, room, id, file = "-";
  std::vector<double> circle;  ///< latitude, longitude in degrees, radius in metres
  std::vector<double> box;     ///< south, west, north, east in degrees
  std::optional<std::int64_t> since_utc_ms, until_utc_ms;
  std::size_t nearest = 0;  ///< of a circle; 0: all
  bool is_public = false;
  bool replaces = false;
  std::uint64_t keep_revisions = 10'000;
};

Result<int> ListAnchors(const ToolArguments& arguments);
Result<int> ShowAnchor(const ToolArguments& arguments);
Result<int> QueryAnchors(const ToolArguments& arguments);
Result<int> ImportAnchors(const ToolArguments& arguments);
Result<int> ExportAnchors(const ToolArguments& arguments);
Result<int> CheckAnchors(const ToolArguments& arguments);
Result<int> CompactAnchors(const ToolArguments& arguments);
Result<int> MigrateAnchors(const ToolArguments& arguments);

}  // namespace waymark::content
