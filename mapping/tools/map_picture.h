// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/io/export_submap.h"

namespace waymark::mapping {

/// A submap to draw.
struct DrawnSubmap {
  ExportSubmap submap;
  Point<Map> centre;
  double radius_m;
};

/// A release seen from above, north up, as a PNG: landmarks as grey dots; each submap as a circle
/// with the images it owns in its colour; images it borrowed as small rings, which shows how
/// submaps overlap; a bar of round length. Errors: Unavailable.
Result<std::vector<std::uint8_t>> DrawMap(const std::vector<DrawnSubmap>& submaps, int side_px);

}  // namespace waymark::mapping
