// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <optional>

#include "mapping/submap/internal/passes.h"

namespace waymark::mapping::internal {

/// How a camera's height above the road beneath it changed along a pass. A vehicle carries its
/// cameras at one height, so where that seems to grow, the scale does.
struct RoadHeights {
  /// Of the height's logarithm, by `along` and by `along`^2 - 1/3 (see Along).
  Eigen::Vector2d drift;
  Eigen::Matrix2d covariance;
};

/// From the points that lie under the path. nullopt: too few of them agree on a surface.
std::optional<RoadHeights> MeasureRoadHeights(const Reconstruction& reconstruction,
                                              const Pass& pass);

}  // namespace waymark::mapping::internal
