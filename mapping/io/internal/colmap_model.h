// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mapping/io/export_submap.h"

namespace waymark::mapping::internal {

/// COLMAP's data model. Positions in the vectors plus one are COLMAP's ids.
struct ColmapModel {
  struct Pixel {
    double x_px;
    double y_px;
    std::uint64_t point;
  };
  struct Image {
    std::string name;
    std::uint32_t camera;
    Transform<Camera, Map> camera_from_map;
    std::vector<Pixel> pixels;
  };
  struct Sighting {
    std::uint32_t image;
    std::uint32_t pixel;  ///< index into Image::pixels
  };
  struct SeenPoint {
    Eigen::Vector3d position_in_map;
    double error_px;  ///< mean reprojection error
    std::vector<Sighting> track;
  };

  std::vector<CameraModel> cameras;
  std::vector<Image> images;
  std::vector<SeenPoint> points;
};

ColmapModel MakeColmapModel(std::span<const ExportSubmap> submaps);

}  // namespace waymark::mapping::internal
