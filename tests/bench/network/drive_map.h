// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/features/features.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::bench {

/// A recorded drive of which every other frame became a map; the others are asked.
struct DriveMap {
  std::filesystem::path map, asked;
};

/// Builds it with waymark-map, unless `scratch` holds it from before. Errors: those of files and of
/// the program.
Result<DriveMap> BuildDriveMap(const std::filesystem::path& drive,
                               const std::filesystem::path& scratch);

struct Picture {
  std::string name;
  mapping::GrayImage image;
  CameraModel camera;
  std::optional<GeoPoint> gnss;  ///< the last before it
};

/// Every n-th picture of a kapture folder. Errors: those of the reader and the images.
Result<std::vector<Picture>> LoadPictures(const std::filesystem::path& folder, std::size_t every);

}  // namespace waymark::bench
