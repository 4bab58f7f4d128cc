// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "content_store/internal/cell_index.h"

namespace waymark::content::internal {

/// Metres between two places on S2's sphere: far cheaper than GeodesicDistance, and near it; the
/// two functions below say how near.
double RoughDistance(const CellPlace& a, const CellPlace& b);

/// The largest rough distance of an anchor's cell whose true distance is not larger than this.
double LargestRough(double true_m);
/// The largest true distance of an anchor at this rough distance.
double LargestTrue(double rough_m);

}  // namespace waymark::content::internal
