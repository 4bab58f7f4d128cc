// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "mapping/submap/internal/measurements.h"

namespace waymark::mapping::internal {

/// What the motion of the recorder's cameras says about whether a body can have moved like that.
struct Kinematics {
  std::vector<PairCheck> speeds;
  std::vector<PairCheck> accelerations;  ///< changes of velocity, m/s
  std::vector<PairCheck> tears;          ///< steps and stops that no acceleration explains, m/s

  bool is_vehicle = false;            ///< the rest is only measured then
  std::vector<PairCheck> sideways;    ///< rad between a step and the camera's usual direction
  std::vector<PairCheck> curvatures;  ///< 1/m, of turns while moving
  std::vector<PairCheck> yaw_rates;   ///< rad/s: heading of the path against the camera's turn
};

/// Metres and up must be known: the reconstruction is geo-aligned.
Kinematics MeasureKinematics(const Reconstruction& reconstruction,
                             std::span<const VerificationImage> images,
                             const VerificationOptions& options);

}  // namespace waymark::mapping::internal
