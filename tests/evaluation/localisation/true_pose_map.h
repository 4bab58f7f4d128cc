// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mapping/base/id.h"
#include "mapping/store/map_directory.h"
#include "mapping/submap/submap_model.h"
#include "tests/evaluation/localisation/city_pictures.h"

namespace waymark::evaluation {

/// A submap in the map frame whose cameras stand where they truly stood; landmarks are triangulated
/// from feature matches as structure from motion would leave them, so their errors are real. Saves
/// minutes per submap, and leaves out what reconstruction adds: errors of the map's own poses.
/// Shapes: equal lengths.
Result<mapping::SubmapModel> TriangulateSubmap(std::span<const TruePicture> pictures,
                                               std::span<const mapping::ImageFeatures> features,
                                               const std::string& experience,
                                               const Parallelism& parallelism);

/// The submap of these pictures in a map directory below the workshop's folder, triangulated unless
/// that has happened before. Its id in the release is that of its content.
Result<mapping::ReleasedSubmap> BuildSubmap(std::span<const TruePicture> pictures,
                                            const std::string& experience,
                                            const Workshop& workshop);

/// The workshop's map directory, made when it is not there. Its origin is the simulated world's.
Result<mapping::MapDirectory> OpenWorkshopMap(const Workshop& workshop);

/// A release of these submaps; nothing is written.
mapping::Release ReleaseOf(std::vector<mapping::ReleasedSubmap> submaps);

}  // namespace waymark::evaluation
