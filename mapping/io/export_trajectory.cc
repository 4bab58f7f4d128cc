// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/export_trajectory.h"

#include <fmt/format.h>

#include <iterator>

#include "mapping/io/internal/export_images.h"

namespace waymark::mapping {

Result<std::string> EncodeTumTrajectory(std::span<const ExportSubmap> submaps) {
  const auto merged = internal::MergeImages(submaps);
  WAYMARK_TRY(internal::CheckNamesHaveNoBlanks(merged, "TUM trajectory"));
  std::string lines;
  for (const internal::ExportedImage& image : merged.images) {
    const auto& t = image.map_from_camera.translation();
    const auto& q = image.map_from_camera.rotation();
    fmt::format_to(std::back_inserter(lines), "{} {} {} {} {} {} {} {}\n", image.name, t.x(), t.y(),
                   t.z(), q.x(), q.y(), q.z(), q.w());
  }
  return lines;
}

}  // namespace waymark::mapping
