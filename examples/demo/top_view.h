// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "examples/demo/assessment.h"
#include "examples/demo/map_truth.h"
#include "mapping/base/result.h"

namespace waymark::demo {

/// Draws the scene from above in the true world, x to the right, y up, with a scale bar and a
/// legend: map points by height, vehicle paths, phone tracks (truth thin, belief thick), anchors as
/// each phone shows them. Errors: Unavailable when the file cannot be written.
Result<void> DrawTopView(const MapPicture& map, const MapAlignment& alignment,
                         const std::vector<WalkedPhone>& phones,
                         const std::vector<AnchorFigures>& anchors,
                         const std::filesystem::path& png);

}  // namespace waymark::demo
