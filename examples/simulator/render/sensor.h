// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/random.h"
#include "examples/simulator/render/lighting.h"
#include "examples/simulator/render/picture.h"

namespace waymark::simulator {

/// How a camera turns light into numbers.
struct SensorOptions {
  float target_mean = 112;  ///< automatic exposure aims here, of 255
  float bias_ev = 0;        ///< brighter or darker than automatic, in stops
  float noise_scale = 1;    ///< times the lighting's noise; 0: none
};

/// Automatic exposure within the lighting's bounds, then noise that grows with gain and brightness,
/// clipped to 8 bits; much noise is smoothed away again (denoise.h). Deterministic in the seed.
ColourImage Expose(const Radiance& radiance, const Lighting& lighting, const SensorOptions& options,
                   Random random);

}  // namespace waymark::simulator
