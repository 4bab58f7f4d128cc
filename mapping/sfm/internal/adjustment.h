// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/estimation/bundle_adjustment.h"
#include "mapping/sfm/incremental.h"
#include "mapping/sfm/internal/gauge.h"
#include "mapping/sfm/internal/model.h"

namespace waymark::mapping::internal {

/// Adjusts all poses, points and intrinsics by cost (1), with the priors that the gauge allows.
Result<BundleSummary> AdjustGlobally(Model& model, const GaugeState& gauge,
                                     const SfmOptions& options, int max_iterations,
                                     double relative_tolerance);

/// Adjusts an image, those that share most points with it, and the points it sees; everything
/// else holds still. Returns the tracks that took part.
Result<std::vector<std::uint32_t>> AdjustLocally(Model& model, std::uint32_t image,
                                                 const GaugeState& gauge,
                                                 const SfmOptions& options);

}  // namespace waymark::mapping::internal
