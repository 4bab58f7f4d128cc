// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "mapping/base/median.h"
#include "mapping/estimation/upright_pose.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::localiser::internal {

/// Features of an image, or of several, beside the landmarks that they may show, one each; equal
/// lengths.
struct ImageMatches {
  std::vector<Eigen::Vector2d> pixels_px;
  std::vector<Eigen::Vector3d> points_in_submap;
  std::vector<double> quality;           ///< higher is clearer
  std::vector<std::uint32_t> landmarks;  ///< indices in the submap; each at most once in an image
  std::vector<std::uint32_t> images;     ///< of a burst, ascending indices; empty: one image

  std::size_t size() const { return pixels_px.size(); }

  /// Takes over one of another's matches; of a burst where `image` is given.
  void Add(const ImageMatches& from, std::size_t i, std::optional<std::uint32_t> image) {
    pixels_px.push_back(from.pixels_px[i]);
    points_in_submap.push_back(from.points_in_submap[i]);
    quality.push_back(from.quality[i]);
    landmarks.push_back(from.landmarks[i]);
    if (image) images.push_back(*image);
  }

  /// From a camera there to the landmarks of some of them.
  double MedianDistance(std::span<const std::uint32_t> chosen,
                        const Eigen::Vector3d& camera_in_submap) const {
    std::vector<double> distances;
    for (const std::uint32_t i : chosen) {
      distances.push_back((points_in_submap[i] - camera_in_submap).norm());
    }
    return Median(std::move(distances));
  }
};

/// What a phone says about its image: its lens, and which way is up, if it knows.
struct ImageSenses {
  CameraModel camera;
  std::optional<mapping::SharedUp> up;  ///< "world" is the submap
};

/// One image of a burst: its lens, and where odometry says that it was taken, in the submap's
/// units.
struct BurstCamera {
  CameraModel camera;
  Rigid3 vo_from_camera;
};

}  // namespace waymark::localiser::internal
