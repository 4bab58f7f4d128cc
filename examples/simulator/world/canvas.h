// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "examples/simulator/random.h"

namespace waymark::simulator {

/// What a surface looks like: reflectance as a display shows it (gamma applied) and how much of it
/// shines by itself, for windows at night. All in [0, 255].
struct Paint {
  float red = 0;
  float green = 0;
  float blue = 0;
  float emission = 0;

  Paint Scaled(double gain) const {
    const auto g = static_cast<float>(gain);
    return {red * g, green * g, blue * g, emission};
  }
};

/// Colours as paint and plaster have them: any brightness within bounds, weakly saturated.
Paint MutedPaint(Random& random, double darkest, double brightest);
/// Strong colours, for signs, doors, awnings and cars.
Paint VividPaint(Random& random);

using Texel = std::array<std::uint8_t, 4>;

/// A picture to paint on: pixel units, origin at the top left corner, clipped at the borders.
/// Thread-compatible.
class Canvas {
 public:
  Canvas(int width_px, int height_px, const Paint& paint);

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }
  std::span<const Texel> texels() const { return texels_; }

  void FillRectangle(double x0, double y0, double x1, double y1, const Paint& paint);
  void FillDisc(double x, double y, double radius, const Paint& paint);
  void DrawLine(double x0, double y0, double x1, double y1, double width, const Paint& paint);
  /// A word of made-up letters, `height` tall from its top left corner.
  void DrawWord(double x, double y, double height, int letters, Random& random, const Paint& paint);
  /// Dirt and weathering: multiplies each texel's colour by 1 + relief.
  void Weather(std::span<const float> relief);

 private:
  int width_px_;
  int height_px_;
  std::vector<Texel> texels_;
};

}  // namespace waymark::simulator
