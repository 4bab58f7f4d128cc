// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mapping/sfm/incremental.h"

namespace waymark::mapping::internal {

/// Images of a camera from which on its distortion can be told from its focal length.
constexpr std::size_t kMinImagesToRefineLens = 10;

/// The cameras as they are adjusted: a pinhole that may be refined and has that many images becomes
/// the same pinhole with radial distortion, none as yet.
std::vector<SfmCamera> AllowDistortion(std::vector<SfmCamera> cameras,
                                       std::span<const SfmImage> images, const SfmOptions& options);

}  // namespace waymark::mapping::internal
