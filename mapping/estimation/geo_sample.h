// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <optional>

#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

/// What is known of one camera of a reconstruction whose frame ("model") is arbitrary.
struct GeoSample {
  Rigid3 model_from_camera;
  std::optional<Eigen::Vector3d> position_in_enu;  ///< GNSS
  double position_sigma_m = 1;
  std::optional<Eigen::Vector3d> up_in_camera;  ///< accelerometer

  /// Where there is one.
  Eigen::Vector3d UpInModel() const { return model_from_camera.rotation() * *up_in_camera; }
  Eigen::Vector3d XAxisInModel() const {
    return model_from_camera.rotation() * Eigen::Vector3d::UnitX();
  }
};

}  // namespace waymark::mapping
