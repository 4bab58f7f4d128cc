// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "mapping/geometry/camera_model.h"

namespace waymark::localiser::internal {

/// The stated camera as a submap knows it: where it was built from pictures of the same camera,
/// their many images tell its focal length and distortion better than a calibration does. The same
/// is what has the size, the principal point and the tangential distortion of the statement, none
/// of which mapping changes, and nearly its focal lengths; its pictures may have been resized, not
/// cut. Otherwise the camera as stated.
CameraModel MappedLens(const CameraModel& stated, std::span<const CameraModel> mapped);

}  // namespace waymark::localiser::internal
