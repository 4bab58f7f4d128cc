// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "mapping/base/result.h"
#include "mapping/store/release.h"

namespace waymark::mapping {

/// Prints in one line how far a release moved what its parent held; nothing without a parent.
Result<void> PrintMovement(const std::string& map_folder, std::uint64_t epoch);

/// "1.23 cm, 0.0456 deg, scale 1.00012"
std::string DescribeDisplacement(const Displacement& displacement);

}  // namespace waymark::mapping
