// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <span>
#include <vector>

#include "mapping/submap/internal/measurements.h"

namespace waymark::mapping::internal {

/// How the reconstruction turned against one unbroken run of the gyroscope.
struct RotationDrift {
  std::vector<PairCheck> checks;  ///< per image, against the run as a whole; from == to
  Eigen::Vector3d bias_rad_per_s = Eigen::Vector3d::Zero();  ///< in camera axes, what explains most
  std::vector<std::uint32_t> images;                         ///< of the run, in order of time
};

/// Pairs of images see sudden turns; this sees those that creep. Along each run every image tells
/// how the first camera stood: its own orientation, turned back by the integrated gyroscope. Where
/// these agree up to a constant bias of the gyroscope, the reconstruction is not bent.
std::vector<RotationDrift> MeasureRotationDrift(const Reconstruction& reconstruction,
                                                std::span<const MeasuredRotation> rotations,
                                                const VerificationOptions& options);

}  // namespace waymark::mapping::internal
