// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "mapping/geometry/angle.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::localiser::internal {

/// A pose and how sure it is.
struct UncertainPose {
  Rigid3 map_from_camera;
  Eigen::Matrix<double, 6, 6> covariance;  ///< of Perturb's delta
};

/// What the vertical that a phone states makes of a pose from its image: few matches in a corner of
/// a picture, or blurred ones, tell a lean from a step only badly, and gravity knows of leans.
/// Frames: the map's z is up
/// Units:  `up_in_camera` of length 1; `sigma` per axis, of phone and map together
/// Source: measurement update of a Kalman filter, linear in Perturb's delta
UncertainPose WithGravity(const UncertainPose& seen, const Eigen::Vector3d& up_in_camera,
                          Angle sigma);

}  // namespace waymark::localiser::internal
