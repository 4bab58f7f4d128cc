// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <array>
#include <vector>

#include "examples/simulator/world/canvas.h"

namespace waymark::simulator {

/// red, green, blue, emission in [0, 255].
using Colour = std::array<float, 4>;

/// The part of a texture that one pixel sees: a point and the two vectors to what the pixels to the
/// right and below see. Texture coordinates: [0, 1], v downwards.
struct Footprint {
  Eigen::Vector2f centre;
  Eigen::Vector2f step_right;
  Eigen::Vector2f step_down;
};

/// What happens outside [0, 1].
enum class TextureBorder { kClamp, kRepeat };

/// A picture with its pyramid of halved copies. Immutable, thread-safe.
class Texture {
 public:
  Texture(const Canvas& canvas, TextureBorder border);

  /// The mean colour under a footprint: several trilinear samples along its long axis, each as wide
  /// as the short one. Neither aliases nor blurs surfaces seen at a flat angle (up to 8:1).
  Colour Sample(const Footprint& footprint) const;

 private:
  struct Level {
    int width;
    int height;
    std::vector<Texel> texels;
  };

  /// Four lanes of 16 bits: the channels in order, in 1/256 of a level.
  std::uint64_t Bilinear(const Level& level, const Eigen::Vector2f& place) const;

  TextureBorder border_;
  std::vector<Level> levels_;
};

}  // namespace waymark::simulator
