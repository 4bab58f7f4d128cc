// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/geometry/camera_model.h"

namespace waymark {

/// The camera of the same picture in another size.
CameraModel ResizeCamera(const CameraModel& camera, int width_px, int height_px);

/// The same lens over another point of the picture.
CameraModel WithPrincipalPoint(const CameraModel& camera, const Eigen::Vector2d& point_px);

}  // namespace waymark
