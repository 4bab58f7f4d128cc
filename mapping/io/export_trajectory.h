// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "mapping/base/result.h"
#include "mapping/io/export_submap.h"

namespace waymark::mapping {

/// One line "name tx ty tz qx qy qz qw" per image, map_from_camera, sorted by name: the TUM
/// trajectory format with names for times. Errors: Unsupported for names with blanks.
Result<std::string> EncodeTumTrajectory(std::span<const ExportSubmap> submaps);

}  // namespace waymark::mapping
