// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::localiser::internal {

/// A feature of an image and a landmark that it looks like, of whatever submap.
struct SeenResemblance {
  std::uint32_t feature;  ///< numbered on from image to image
  std::uint32_t image;
  Eigen::Vector2d pixel_px;
  Eigen::Vector3d point_in_map;
};

/// An image of a request, where a pose puts it.
struct PlacedImage {
  CameraModel camera;
  Rigid3 map_from_camera;
};

struct RivalOptions {
  double max_error_px = 6;  ///< reprojection error of a supporter
  double same_place_m = 1;  ///< nearer landmarks and poses are not elsewhere
};

/// How well the best pose elsewhere explains what a pose explains.
struct Rivalry {
  std::size_t supporters = 0;  ///< features that look like a landmark where the pose sees one
  std::size_t rivals = 0;      ///< features that do so for the other pose
  /// How many of each there would be if landmarks lay in the image by chance. The more submaps are
  /// asked, the more there are.
  double chance_supporters = 0;
  double chance_rivals = 0;
  Rigid3 map_from_camera;  ///< the other pose of the last image

  /// Rivals over supporters, of each what is beyond chance; three sigma more of the rivals, whose
  /// pose was chosen to have many. Can be below 0.
  double Share() const;
};

/// Looks for the pose elsewhere that explains most features, among all landmarks that they look
/// like: no ratio test has thrown away what copies of a place share. What is copied is assumed to
/// stand upright. The images of a burst keep their places beside each other.
/// Deterministic. Shapes: resemblances sorted by feature; at least one image.
Rivalry FindRival(std::span<const PlacedImage> images,
                  std::span<const SeenResemblance> resemblances, const RivalOptions& options);

}  // namespace waymark::localiser::internal
