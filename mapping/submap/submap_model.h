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

/// One thing that was checked.
struct VerificationFigure {
  std::string name;  ///< with its unit: "gyroscope_rad"
  double value = 0;  ///< the worst, or the median where `count` is 1
  double bound = 0;  ///< of that value
  int broken = 0;    ///< how many were beyond their bounds,
  int count = 0;     ///< of how many
};

/// What was checked before the submap was accepted, with the figures.
struct VerificationEvidence {
  bool accepted = true;
  std::string verdict;                           ///< one sentence
  std::vector<VerificationFigure> figures = {};  ///< not in submap files, the verdict is
  bool gnss_is_trusted = true;  ///< false: it lies, and assembly leaves it out; not in files either
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
