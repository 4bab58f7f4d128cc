// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "mapping/geometry/camera_model.h"

namespace waymark::mapping {

/// A projection with its derivatives.
struct ProjectionWithDerivatives {
  Eigen::Vector2d pixel_px;
  Eigen::Matrix2d by_normalized;              ///< by (x/z, y/z)
  Eigen::Matrix<double, 2, 8> by_parameters;  ///< unused columns are zero
};

/// ProjectNormalized and its exact derivatives.
ProjectionWithDerivatives ProjectWithDerivatives(CameraKind kind, const double* parameters,
                                                 const Eigen::Vector2d& normalized);

/// The derivative of (x/z, y/z) by (x, y, z).
inline Eigen::Matrix<double, 2, 3> NormalizationDerivative(const Eigen::Vector3d& x_in_camera) {
  const double inverse = 1 / x_in_camera.z();
  Eigen::Matrix<double, 2, 3> derivative;
  derivative << inverse, 0, -x_in_camera.x() * inverse * inverse,  //
      0, inverse, -x_in_camera.y() * inverse * inverse;
  return derivative;
}

}  // namespace waymark::mapping
