// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <span>
#include <vector>

#include "mapping/submap/internal/measurements.h"

namespace waymark::mapping::internal {

/// A reconstructed position with what GNSS says.
struct PassPlace {
  std::uint32_t image;
  double seconds;
  Eigen::Vector2d path;
  Eigen::Vector2d gnss;
  double height_m;     ///< of the reconstructed position
  double along_m = 0;  ///< since the pass began
};

/// What one camera recorded without a long pause.
using Pass = std::vector<PassPlace>;

/// From -1 where a pass begins to 1 where it ends.
inline double Along(const Pass& pass, double along_m) {
  return 2 * along_m / pass.back().along_m - 1;
}

/// Those that are long enough to have a shape: at least 20 m, 4 s and 6 positions.
std::vector<Pass> CollectPasses(const Reconstruction& reconstruction,
                                std::span<const VerificationImage> images);

}  // namespace waymark::mapping::internal
