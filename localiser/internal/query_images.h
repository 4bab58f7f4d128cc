// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/experience/experience.h"
#include "mapping/features/features.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::localiser::internal {

/// A place as a GNSS receiver knows it.
struct GnssPlace {
  GeoPoint place;
  double sigma_m;
};

/// An image on disk that asks where it was taken.
struct QueryImage {
  std::string name;
  std::filesystem::path path;
  std::optional<CameraModel> camera;  ///< absent: to be guessed from the image's size
  std::optional<GnssPlace> gnss;
};

/// What QUERY on the command line means: a kapture folder if it holds sensors/sensors.txt, else all
/// JPEG and PNG files below it. `camera` describes plain images and overrides kapture's own.
/// Errors: NotFound (no folder, no image), and those of kapture.
Result<std::vector<QueryImage>> FindQueryImages(const std::filesystem::path& folder,
                                                const std::optional<CameraModel>& camera);

/// Keeps the images whose names stand in a text file, one per line, in that order.
/// Errors: NotFound for the file, or for a name that is not among the images.
Result<std::vector<QueryImage>> SelectListed(std::span<const QueryImage> images,
                                             const std::filesystem::path& list);

/// Where an experience was at an instant: between two records, or at the nearest one within 5 s.
std::optional<GnssPlace> GnssAt(const mapping::Experience& experience, SensorTime time);

/// "PINHOLE,640,480,520,520,320,240": kind, width, height, parameters, as in kapture's sensors.txt.
/// Errors: InvalidArgument.
Result<CameraModel> ParseCamera(std::string_view text);

/// A pinhole with the focal length of 1.2 times the longer side, a common lens of phones.
Result<CameraModel> GuessCamera(const mapping::GrayImage& image);

}  // namespace waymark::localiser::internal
