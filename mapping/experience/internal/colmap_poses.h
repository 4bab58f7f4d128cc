// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping::internal {

/// What a COLMAP model says of its images; points are not read.
struct ColmapPoses {
  struct Image {
    std::string name;
    std::uint32_t camera;
    Rigid3 camera_from_world;
  };
  std::map<std::uint32_t, CameraModel> cameras;
  std::vector<Image> images;  ///< sorted by name, no two alike
};

/// Reads cameras.bin and images.bin of a folder, or the .txt files where there are no such. Every
/// byte is treated as hostile.
/// Errors: NotFound; Corrupt with file and line or byte; Unsupported (a camera model that is not
/// one of CameraKind).
/// Source: COLMAP 3.8 documentation, "Output format".
Result<ColmapPoses> LoadColmapPoses(const std::filesystem::path& folder);

}  // namespace waymark::mapping::internal
