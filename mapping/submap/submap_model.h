// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mapping/base/id.h"
#include "mapping/features/features.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/frames.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::mapping {

/// An image that stands in a submap. The same (experience, name) in two submaps is the same image:
/// that is what fusion joins.
struct SubmapImage {
  ExperienceId experience;
  std::string name;
  std::uint32_t camera;  ///< index into SubmapModel::cameras
  Transform<Submap, Camera> submap_from_camera;
  std::optional<GeoPoint> gnss;  ///< prior of the camera centre
  double gnss_sigma_m = 1;
  bool is_borrowed = false;  ///< belongs to a neighbouring subset, here only for fusion
};

/// One sighting of a landmark: what localisation searches.
struct LandmarkObservation {
  std::uint32_t landmark;
  std::uint32_t image;
  float x_px;
  float y_px;
  Descriptor descriptor;
};

/// What was checked before the submap was accepted, with the figures.
struct VerificationEvidence {
  bool accepted = true;
  std::string verdict;  ///< one sentence
  double max_gyroscope_error_rad = 0;
  double max_gravity_error_rad = 0;
  double max_speed_mps = 0;
  double mean_reprojection_px = 0;
};

/// One accepted piece of the map. Immutable after building; frame: ENU at `origin`, metres, so
/// that only small corrections remain for map_from_submap.
struct SubmapModel {
  GeoPoint origin;
  bool is_geo_aligned = true;
  /// How well its scale is known without GNSS, relative, > 0; absent: not at all.
  std::optional<double> scale_sigma = std::nullopt;
  std::vector<CameraModel> cameras;
  std::vector<SubmapImage> images;
  std::vector<Point<Submap>> landmarks;
  std::vector<LandmarkObservation> observations;  ///< sorted by (landmark, image)
  VerificationEvidence evidence;
};

}  // namespace waymark::mapping
