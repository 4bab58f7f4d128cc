// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "mapping/submap/internal/measurements.h"

namespace waymark::mapping::internal {

/// One way of bending a path, in metres of its largest displacement.
struct Bending {
  double metres = 0;
  double sigma_m = 0;  ///< how well it is known
};

/// What the height of a vehicle's camera above the road says of a pass's scale.
struct RoadScale {
  Bending by_road;  ///< how far it drifts
  Bending by_both;  ///< the same by road and GNSS together
  Bending dispute;  ///< how far the two are from each other
};

/// How one pass of one camera must be bent until it lies on its GNSS positions, after the best
/// similarity. Horizontal: satellites say little about heights.
struct GnssShape {
  std::uint32_t first;  ///< image
  std::uint32_t last;
  double seconds;
  Bending scale = {};                            ///< its scale drifts
  std::optional<RoadScale> road = std::nullopt;  ///< absent where the road is not known
  Bending bend = {};                             ///< its heading drifts, one way
  Bending double_bend = {};                      ///< one way and back
  double turn_rad_per_s = 0;  ///< by `bend`, left positive, on average over the pass
  double turn_sigma_rad_per_s = 0;
  double largest_jump_m = 0;  ///< of GNSS against the path within a second
  double jump_bound_m = 0;
  double noise_m = 0;  ///< of GNSS around the bent path, one axis
};

/// Of every pass; `on_road`: cameras keep their height above the road.
std::vector<GnssShape> MeasureGnssShape(const Reconstruction& reconstruction,
                                        std::span<const VerificationImage> images, bool on_road);

}  // namespace waymark::mapping::internal
