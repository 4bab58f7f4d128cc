// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <array>
#include <vector>

#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

/// A ray of a rig of cameras: through `origin`, along `bearing`, of length 1.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d bearing;
};

/// Appends the at most two poses world_from_rig that see two points along two rays, in front, where
/// both frames have z up: heading and place are the four unknowns. None when both rays are level or
/// the points lie above each other.
/// Source: the problem of Kukelova, Bujnak & Pajdla, "Closed-form solutions to minimal absolute
///         pose problems with known vertical direction", ACCV 2010, for rays that need not meet;
///         solved here for the distances.
void SolveUprightRig(const std::array<Ray, 2>& rays_in_rig,
                     const std::array<Eigen::Vector3d, 2>& points_in_world,
                     std::vector<Rigid3>& world_from_rig);

}  // namespace waymark::mapping
