// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/estimation/bundle_adjustment.h"

namespace waymark::mapping::internal {

/// AdjustBundle by Ceres, for a valid problem with observations.
Result<BundleSummary> AdjustBundleWithCeres(BundleProblem& problem, const BundleOptions& options);

}  // namespace waymark::mapping::internal
