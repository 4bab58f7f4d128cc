// SPDX-License-Identifier: Apache-2.0
#include "mapping/tools/movement.h"

#include <fmt/format.h>

#include "mapping/geometry/angle.h"
#include "mapping/store/map_directory.h"
#include "mapping/store/release_diff.h"

namespace waymark::mapping {

std::string DescribeDisplacement(const Displacement& displacement) {
  return fmt::format("{:.2f} cm, {:.4f} deg, scale {:.6f}", 100 * displacement.translation_m,
                     Angle::Radians(displacement.rotation_rad).degrees(), displacement.scale_ratio);
}

Result<void> PrintMovement(const std::string& map_folder, std::uint64_t epoch) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(map_folder));
  WAYMARK_TRY_ASSIGN(const Release release, map.LoadRelease(epoch));
  if (!release.parent_epoch) return {};
  WAYMARK_TRY_ASSIGN(const Release parent, map.LoadRelease(*release.parent_epoch));
  const ReleaseDiff diff = CompareReleases(parent, release);
  fmt::print("since epoch {}: {} added, {} removed", parent.epoch, diff.added.size(),
             diff.removed.size());
  if (!diff.moved.empty()) {
    fmt::print(", {} others moved by {:.2f} cm in the median, {:.2f} cm at worst (submap {})",
               diff.moved.size(), 100 * diff.median.translation_m, 100 * diff.worst.translation_m,
               diff.moved.front().id.text());
  }
  fmt::print("\n");
  return {};
}

}  // namespace waymark::mapping
