// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/sfm/internal/model.h"

namespace waymark::mapping::internal {

/// Moves the pixels of images with a rolling shutter to where a camera that exposes all rows at the
/// image's time would have seen them: each row was exposed while the camera, on its way from its
/// image before to its image after, stood elsewhere, and moved what it saw of a point at that
/// depth. Motion and depths come from the model as it is, so a finished model is corrected and
/// adjusted in turns. Pixels of images whose motion is unknown stay as measured.
/// Returns whether there was anything to correct.
bool CorrectRollingShutter(Model& model);

}  // namespace waymark::mapping::internal
