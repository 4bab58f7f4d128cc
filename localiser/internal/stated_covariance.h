// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "mapping/geometry/camera_model.h"

namespace waymark::localiser::internal {

/// What a pose may truly be off by, from the covariance that refinement states for independent
/// errors of its matches. They are not: several features lie on one corner, landmarks were seen in
/// the same images, and a whole image is shifted by a fraction of a pixel, which turns the camera.
/// And the map itself is not exact: landmarks that are seen together are off together.
/// Frames: of Perturb's delta, as both covariances. README.md has the measurement.
/// Units:  `distance` from the camera to what it sees, in those of the positions
Eigen::Matrix<double, 6, 6> StatedCovariance(const Eigen::Matrix<double, 6, 6>& of_independent,
                                             const CameraModel& camera, double distance);

}  // namespace waymark::localiser::internal
