// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "mapping/base/result.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::demo {

/// World_from_camera of each image, by name, in the simulator's world (ENU at its origin, metres).
using TruePoses = std::map<std::string, Rigid3>;

/// Reads "image tx ty tz qx qy qz qw" lines. Errors: NotFound; Corrupt with file and line.
Result<TruePoses> LoadTruePoses(const std::filesystem::path& file);

}  // namespace waymark::demo
