// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <optional>
#include <vector>

#include "mapping/estimation/upright_pose.h"
#include "mapping/geometry/camera_model.h"

namespace waymark::localiser::internal {

/// Features of an image beside the landmarks that they may show, one each; equal lengths.
struct ImageMatches {
  std::vector<Eigen::Vector2d> pixels_px;
  std::vector<Eigen::Vector3d> points_in_submap;
  std::vector<double> quality;  ///< higher is clearer

  std::size_t size() const { return pixels_px.size(); }
};

/// What a phone says about its image: its lens, and which way is up, if it knows.
struct ImageSenses {
  CameraModel camera;
  std::optional<mapping::SharedUp> up;  ///< "world" is the submap
};

}  // namespace waymark::localiser::internal
