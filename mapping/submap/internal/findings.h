// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mapping/submap/internal/gnss_shape.h"
#include "mapping/submap/internal/kinematics.h"
#include "mapping/submap/internal/rotation_drift.h"

namespace waymark::mapping::internal {

/// One kind of check over all images: the value that is worst against its bound, how many broke
/// theirs, of how many.
struct Tally {
  double worst = 0;
  double bound = 0;  ///< of the worst
  int broken = 0;
  int count = 0;

  void Add(double value, double its_bound);
  void Add(std::span<const PairCheck> checks);
  bool Fails(double tolerated_share) const { return broken > tolerated_share * count; }
};

/// Everything measured about one reconstruction.
struct Findings {
  int registered = 0;
  int owned = 0;
  int owned_registered = 0;
  Tally gyroscope;
  Tally drift;
  Tally bias;
  Tally speed;
  Tally acceleration;
  Tally tear;
  bool is_vehicle = false;
  Tally sideways;
  Tally curvature;
  Tally yaw_rate;
  Tally scale_drift;  ///< against GNSS and, where it is known, the road
  Tally road_drift;   ///< of scale, against the road alone; judges only together with GNSS
  Tally bend;         ///< against GNSS, where the gyroscope does not know better
  Tally gnss_lie;     ///< bends that the gyroscope denies, and jumps
  std::vector<double> gravity_rad;
  double worst_gravity_rad = 0;  ///< median of the worst third of the submap
  std::vector<double> gnss_m;
  std::vector<double> gnss_sigmas;
};

Findings MeasureAll(const Reconstruction& reconstruction, std::span<const VerificationImage> images,
                    std::span<const MeasuredRotation> rotations,
                    const VerificationOptions& options);

/// By name, in a fixed order; those whose sensor is absent are left out.
std::vector<VerificationFigure> ListFigures(const Reconstruction& reconstruction,
                                            const Findings& found,
                                            const VerificationOptions& options);

}  // namespace waymark::mapping::internal
