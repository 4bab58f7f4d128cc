// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

/// A camera at a place of a z-up world. Yaw 0 looks along +y, positive turns left (towards -x);
/// positive pitch looks up; roll turns about the viewing direction.
/// Result: world_from_camera
Rigid3 PlaceCamera(const Eigen::Vector3d& position, double yaw_rad, double pitch_rad = 0,
                   double roll_rad = 0);

/// Positions along +y at eye height, looking ahead and turned by `yaw_rad`.
std::vector<Rigid3> WalkStraight(const Eigen::Vector3d& start, double step_m, int count,
                                 double yaw_rad = 0);

/// A circle around the origin, looking outwards.
std::vector<Rigid3> WalkCircle(double radius_m, double height_m, int count);

/// Turns on the spot.
std::vector<Rigid3> TurnInPlace(const Eigen::Vector3d& position, double step_rad, int count);

}  // namespace waymark::mapping
