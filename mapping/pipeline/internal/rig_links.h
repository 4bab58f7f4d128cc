// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mapping/pipeline/internal/task_input.h"
#include "mapping/sfm/incremental.h"

namespace waymark::mapping {

/// For each image the other cameras of its rig, between the two images of theirs around its time.
/// Cameras need no common trigger: a second between two images is bridged, and the less certain the
/// longer it is.
std::vector<RigLink> LinkRigs(const TaskInput& input);

}  // namespace waymark::mapping
