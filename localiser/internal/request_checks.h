// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "localiser/localiser.h"

namespace waymark::localiser::internal {

/// How a request contradicts itself; nullopt: it does not. Whoever asks is not trusted.
std::optional<std::string> FindContradiction(const LocalisationRequest& request);

/// The same of a burst: its size, each of its requests, poses that are none, gravity that is not
/// odometry's. Its z is up, good to twice `max_gravity_error`.
std::optional<std::string> FindContradiction(const BurstRequest& burst, Angle max_gravity_error);

/// Odometry's up, as a camera knows it.
Eigen::Vector3d UpInCamera(const Transform<Vo, Camera>& vo_from_camera);

}  // namespace waymark::localiser::internal
