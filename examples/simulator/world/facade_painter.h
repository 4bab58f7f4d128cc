// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/world/canvas.h"
#include "examples/simulator/world/facade_plan.h"

namespace waymark::simulator {

/// The unique picture of one house front: wall, openings and what stands behind them, shop signs,
/// dirt. `texels_per_m` along both axes.
Canvas PaintFacade(const FacadePlan& plan, double texels_per_m, Random random);

}  // namespace waymark::simulator
