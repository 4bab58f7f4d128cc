// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "examples/simulator/world/canvas.h"

namespace waymark::simulator {

/// An area of a canvas in pixels.
struct PixelArea {
  double left;
  double top;
  double right;
  double bottom;

  double width() const { return right - left; }
  double height() const { return bottom - top; }
};

/// A window with frame and varied contents: curtains, blinds, plants, lamps, reflections.
void PaintWindow(Canvas& canvas, const PixelArea& area, const Paint& frame, Random& random);
/// A shop window full of goods, posters and lettering.
void PaintShopWindow(Canvas& canvas, const PixelArea& area, const Paint& frame, Random& random);
void PaintDoor(Canvas& canvas, const PixelArea& area, Random& random);
/// A board with a word on it.
void PaintSign(Canvas& canvas, const PixelArea& area, Random& random);

}  // namespace waymark::simulator
