// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/examples/simulator/small_world.h"

namespace waymark::simulator {

/// The view of a small camera.
inline constexpr int kWidth = 160;
inline constexpr int kHeight = 120;

inline ViewRays TestRays() {
  return ViewRays(*MakeCamera({.width_px = kWidth, .height_px = kHeight}));
}

inline float RedAt(const Radiance& image, int column, int row) {
  return image.values[3 * static_cast<std::size_t>(row * kWidth + column)];
}

}  // namespace waymark::simulator
