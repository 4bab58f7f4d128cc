// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace waymark::simulator {

/// One scale of texture: smooth bumps about `cell_px` wide.
struct NoiseOctave {
  float cell_px;    ///< >= 1
  float amplitude;  ///< standard deviation of the bumps
};

/// A field of bumps at several scales with mean 0, row by row. Deterministic in the seed.
/// Bicubic B-spline interpolation of white noise on a lattice per octave.
std::vector<float> MakeNoise(int width_px, int height_px, const std::vector<NoiseOctave>& octaves,
                             std::uint64_t seed);

}  // namespace waymark::simulator
