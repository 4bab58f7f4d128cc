// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "mapping/base/result.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

/// World_from_camera by the name of an image, or by the text of its timestamp.
using NamedPoses = std::map<std::string, Rigid3>;

/// Lines of "name tx ty tz qx qy qz qw", as TUM's trajectories; empty lines and those that start
/// with # are skipped. Errors: Corrupt with `file` and line.
Result<NamedPoses> ParseTumTrajectory(std::string_view text, std::string_view file);

}  // namespace waymark::mapping
