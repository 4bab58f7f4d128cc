// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "examples/demo/truth.h"
#include "mapping/base/result.h"
#include "mapping/geometry/frames.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::demo {

/// The simulator's world: ENU at its own origin. Only reports know it.
struct World;

/// A live map as a report needs it.
struct MapPicture {
  std::uint64_t epoch = 0;
  std::size_t submap_count = 0;
  std::vector<Point<Map>> landmarks;
  struct MappedImage {
    std::string experience;
    std::string name;
    Transform<Map, Camera> map_from_camera;
  };
  std::vector<MappedImage> images;
  GeoPoint origin;
};

/// Reads the live release of a map. Errors: those of the map directory.
Result<MapPicture> LoadMapPicture(const std::filesystem::path& map);

/// How the map lies in the true world.
struct MapAlignment {
  Transform<World, Map> by_geodesy;  ///< from the two origins: includes the map's GNSS error
  Transform<World, Map> by_fit;      ///< rigid, best on the vehicles' true camera positions
  double camera_rms_m = 0;           ///< of the vehicles' cameras after the fit
  double shape_rms_m = 0;        ///< of the same after a similarity: what is not the map's scale
  double scale_error = 0;        ///< of the map; monocular drives have theirs from GNSS alone
  double geodetic_offset_m = 0;  ///< how far the two differ at the map's middle
};

/// `true_vehicle_poses` holds "<experience>/<image>" names.
/// Errors: InvalidArgument when fewer than 3 mapped images have a truth.
Result<MapAlignment> AlignMapToTruth(const MapPicture& map, const GeoPoint& world_origin,
                                     const TruePoses& true_vehicle_poses);

}  // namespace waymark::demo
