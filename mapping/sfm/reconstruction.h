// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/frames.h"

namespace waymark::mapping {

/// One image of a reconstruction. `submap_from_camera` is absent when it could not be registered.
struct ReconstructedImage {
  std::uint32_t camera;  ///< index into Reconstruction::cameras
  std::optional<Transform<Submap, Camera>> submap_from_camera;
  std::string exclusion;  ///< why it is not registered; empty when it is
};

struct TrackElement {
  std::uint32_t image;    ///< index into the input images
  std::uint32_t feature;  ///< index into that image's features
};

struct ReconstructedPoint {
  Point<Submap> position;
  std::vector<TrackElement> track;  ///< sorted by image; only registered images
};

/// The outcome of structure from motion: images in input order, refined cameras, points.
struct Reconstruction {
  std::vector<CameraModel> cameras;
  std::vector<ReconstructedImage> images;
  std::vector<ReconstructedPoint> points;
  double mean_reprojection_px = 0;
  bool is_geo_aligned = false;  ///< false: the gauge is arbitrary (no or degenerate GNSS)
  /// How well the rig tells the scale, relative; absent: it does not.
  std::optional<double> scale_sigma = std::nullopt;
};

}  // namespace waymark::mapping
