// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/world/canvas.h"

namespace waymark::simulator {

/// A stretch of street from above: pavement, road, pavement from top to bottom.
struct StreetPicture {
  double length_m;
  double road_m;
  double pavement_m;
  double texels_per_m;
};

/// Asphalt with markings, patches, cracks and covers between slabs with spots and kerb stones.
Canvas PaintStreet(const StreetPicture& street, Random random);
/// Where streets meet: asphalt with slabs in the four corners.
Canvas PaintCrossing(const StreetPicture& street, Random random);

}  // namespace waymark::simulator
