// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <set>
#include <string>

#include "mapping/base/result.h"
#include "tests/evaluation/trajectory.h"

namespace waymark::evaluation {

/// Makes `link` stand for `target`, wherever that is named from. Errors: Unavailable.
Result<void> LinkFile(const std::filesystem::path& target, const std::filesystem::path& link);

/// Which images of an experience stay, by their place in time and their name.
using ImageFilter = std::function<bool(std::size_t index, const std::string& name)>;

/// Writes a kapture folder with some of another's images; the pictures are linked, not copied.
/// GNSS and IMU stay whole. Returns the names that stayed. Errors: those of files.
Result<std::set<std::string>> StoreKaptureSubset(const std::filesystem::path& from,
                                                 const std::filesystem::path& to,
                                                 const ImageFilter& keep);

/// The poses of a map's live release, one per image: in several submaps, the one it belongs to.
struct MapPoses {
  Trajectory map_from_camera;
  std::size_t submaps = 0;
  std::size_t largest_submap = 0;  ///< in images of its own
};

/// Errors: those of the map directory and its submaps.
Result<MapPoses> LoadMapPoses(const std::filesystem::path& map);

}  // namespace waymark::evaluation
