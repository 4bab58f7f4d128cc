// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "mapping/io/export_submap.h"

namespace waymark::mapping {

/// A binary little-endian PLY of all landmarks in the map frame: x, y, z as double, because a city
/// is too large for float, and `submap`, the position of the landmark's submap in the span.
std::string EncodePlyPoints(std::span<const ExportSubmap> submaps);

}  // namespace waymark::mapping
