// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "mapping/split/split.h"

namespace waymark::mapping {

/// The images without the positions that nothing can have reached from where most of those within
/// three seconds are, at 60 m/s. Where fewer than three others are so near in time, all stay.
std::vector<SplitImage> WithoutOutliers(std::span<const SplitImage> images);

}  // namespace waymark::mapping
