// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/io/export_submap.h"

namespace waymark::mapping::internal {

/// An image as an export shows it: once, in the map frame.
struct ExportedImage {
  std::string name;    ///< image name, below its experience's id when there are several experiences
  std::size_t submap;  ///< which submap it was taken from
  std::uint32_t image;  ///< and which of its images it is
  Transform<Map, Camera> map_from_camera;
};

struct ExportedImages {
  std::vector<ExportedImage> images;  ///< sorted by name
  /// For each image of each submap, its place in `images`.
  std::vector<std::vector<std::uint32_t>> places;
};

ExportedImages MergeImages(std::span<const ExportSubmap> submaps);

/// Text formats separate by blanks and cannot quote. Errors: Unsupported, naming the image.
Result<void> CheckNamesHaveNoBlanks(const ExportedImages& merged, std::string_view format);

}  // namespace waymark::mapping::internal
