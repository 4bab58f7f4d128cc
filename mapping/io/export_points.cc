// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/export_points.h"

#include <fmt/format.h>

#include "mapping/io/internal/binary_text.h"

namespace waymark::mapping {

std::string EncodePlyPoints(std::span<const ExportSubmap> submaps) {
  std::size_t count = 0;
  for (const ExportSubmap& submap : submaps) count += submap.landmark_count();
  std::string ply = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment map frame: east, north, up, metres\n"
      "element vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
      "property int submap\nend_header\n",
      count);
  for (std::size_t s = 0; s < submaps.size(); ++s) {
    for (std::size_t i = 0; i < submaps[s].landmark_count(); ++i) {
      const auto landmark_in_map = submaps[s].map_from_submap() * submaps[s].Landmark(i);
      for (const double component : landmark_in_map.coordinates()) {
        internal::AppendBinary(ply, component);
      }
      internal::AppendBinary(ply, static_cast<std::int32_t>(s));
    }
  }
  return ply;
}

}  // namespace waymark::mapping
