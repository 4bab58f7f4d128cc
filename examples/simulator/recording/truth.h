// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "examples/simulator/recording/recording.h"

namespace waymark::simulator {

/// Where every picture was taken: lines "name tx ty tz qx qy qz qw", world_from_camera; the world
/// is east, north, up at the stated origin, metres.
std::string EncodeCameraTruth(const Recording& recording);

/// Where the body was at every odometry sample: lines "nanoseconds tx ty tz qx qy qz qw",
/// world_from_device, on the recorder's clock.
std::string EncodeDeviceTruth(const Recording& recording);

}  // namespace waymark::simulator
