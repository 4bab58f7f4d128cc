// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include "mapping/features/internal/extrema.h"
#include "mapping/features/internal/sift_kernels.h"

namespace waymark::mapping::internal {

/// Of two neighbouring bins only one can be a peak.
using OrientationRoom = std::array<float, kOrientationBins / 2>;

/// The directions that the gradients around an extremum have in common, clockwise from +x, in
/// [0, 2 pi), ascending: peaks of at least four fifths of the highest. Seldom none. They are
/// written to `room`.
/// Source: Lowe 2004, section 5.
std::span<const float> FindOrientations_rad(const Plane& layer, const Extremum& extremum,
                                            const SiftKernels& kernels, OrientationRoom& room);

}  // namespace waymark::mapping::internal
