// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/random.h"
#include "examples/simulator/render/picture.h"

namespace waymark::simulator {

/// Lets it rain between the scene and the sensor: bright streaks in the air, and drops on the lens
/// that show what lies behind them small, upside down and blurred. `rain` in [0, 1].
void AddRain(float rain, Random random, Radiance& image);

}  // namespace waymark::simulator
