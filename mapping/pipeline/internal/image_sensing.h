// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mapping/pipeline/internal/experience_index.h"

namespace waymark::mapping {

/// Fills in what GNSS and IMU say about each image: position of the camera, up, and the rotation
/// to the next image of the same camera. Images are sorted by time.
///
/// The antenna's position becomes the camera's where the rig is known: the vertical part of the
/// lever arm is added, because the accelerometer tells it; the horizontal part needs a heading
/// that nobody measured, so it widens the standard deviation instead.
void SenseImages(const Experience& experience, const TangentPlane& map,
                 std::vector<IndexedImage>& images);

}  // namespace waymark::mapping
