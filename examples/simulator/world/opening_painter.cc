// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/opening_painter.h"

#include <algorithm>
#include <cmath>

namespace waymark::simulator {
namespace {

void Fill(Canvas& canvas, const PixelArea& area, const Paint& paint) {
  canvas.FillRectangle(area.left, area.top, area.right, area.bottom, paint);
}

/// What the glass shows: dark room above, reflected street and sky in slanted patches.
void PaintGlass(Canvas& canvas, const PixelArea& area, bool is_lit, Random& random) {
  Paint glass = MutedPaint(random, 25, 85);
  glass.blue += 12;
  glass.emission = is_lit ? random.UniformFloat(120, 255) : 0;
  Fill(canvas, area, glass);
  const double split = area.top + area.height() * random.Uniform(0.25, 0.7);
  Paint reflection = MutedPaint(random, 80, 190);
  reflection.emission = glass.emission;
  const int steps = 8;
  double level = split;
  for (int i = 0; i < steps; ++i) {  // a skyline of the houses opposite
    const double left = area.left + area.width() * i / steps;
    level = std::clamp(level + random.Uniform(-0.12, 0.12) * area.height(), area.top, area.bottom);
    canvas.FillRectangle(left, area.top, left + area.width() / steps + 1, level, reflection);
  }
}

void PaintCurtains(Canvas& canvas, const PixelArea& area, float emission, Random& random) {
  const double reach = area.width() * random.Uniform(0.14, 0.42);
  const Paint cloth = MutedPaint(random, 110, 235);
  const double fold = std::max(3.0, area.width() * 0.05);
  for (double x = 0; x < reach; x += fold) {
    Paint paint = cloth.Scaled(random.Uniform(0.72, 1.08));
    paint.emission = emission;
    canvas.FillRectangle(area.left + x, area.top, area.left + x + fold, area.bottom, paint);
    canvas.FillRectangle(area.right - x - fold, area.top, area.right - x, area.bottom, paint);
  }
}

void PaintBlind(Canvas& canvas, const PixelArea& area, Random& random) {
  const double bottom = area.top + area.height() * random.Uniform(0.15, 0.95);
  const Paint slat = MutedPaint(random, 90, 230);
  const double pitch = std::max(4.0, area.height() * 0.05);
  for (double y = area.top; y < bottom; y += pitch) {
    const double lean = random.Uniform(-1, 1);
    canvas.DrawLine(area.left, y + lean, area.right, y - lean, pitch * 0.72,
                    slat.Scaled(random.Uniform(0.85, 1.05)));
  }
}

void PaintPlants(Canvas& canvas, const PixelArea& area, Random& random) {
  const int leaves = random.Integer(8, 26);
  for (int i = 0; i < leaves; ++i) {
    const Paint leaf{random.UniformFloat(20, 120), random.UniformFloat(60, 170),
                     random.UniformFloat(10, 80), 0};
    canvas.FillDisc(random.Uniform(area.left, area.right),
                    area.bottom - std::abs(random.Normal(0.14)) * area.height(),
                    random.Uniform(2, 0.06 * area.width() + 2.5), leaf);
  }
}

void PaintThings(Canvas& canvas, const PixelArea& area, int count, Random& random) {
  for (int i = 0; i < count; ++i) {
    const double x = random.Uniform(area.left, area.right);
    const double width = random.Uniform(0.05, 0.22) * area.width();
    const double height = random.Uniform(0.08, 0.5) * area.height();
    const Paint paint = random.Chance(0.5) ? VividPaint(random) : MutedPaint(random, 20, 230);
    const double foot = area.bottom - random.Uniform(0, 0.3) * area.height();
    canvas.FillRectangle(x, foot - height, std::min(x + width, area.right), foot, paint);
    canvas.FillDisc(std::min(x + width / 2, area.right), foot - height, width * 0.35,
                    paint.Scaled(random.Uniform(0.6, 1.3)));
  }
}

void PaintBars(Canvas& canvas, const PixelArea& area, const Paint& frame, int columns, int rows) {
  const double bar = std::max(2.5, 0.035 * area.width());
  for (int i = 1; i < columns; ++i) {
    const double x = area.left + area.width() * i / columns;
    canvas.FillRectangle(x - bar / 2, area.top, x + bar / 2, area.bottom, frame);
  }
  for (int i = 1; i < rows; ++i) {
    const double y = area.top + area.height() * i / rows;
    canvas.FillRectangle(area.left, y - bar / 2, area.right, y + bar / 2, frame);
  }
}

PixelArea Inset(const PixelArea& area, double by) {
  return {area.left + by, area.top + by, area.right - by, area.bottom - by};
}

}  // namespace

void PaintWindow(Canvas& canvas, const PixelArea& area, const Paint& frame, Random& random) {
  Fill(canvas, area, frame);
  const PixelArea glass = Inset(area, std::max(3.0, 0.05 * area.width()));
  const bool is_lit = random.Chance(0.3);
  PaintGlass(canvas, glass, is_lit, random);
  if (random.Chance(0.35)) PaintThings(canvas, glass, random.Integer(1, 4), random);
  if (random.Chance(0.45)) PaintCurtains(canvas, glass, is_lit ? 90 : 0, random);
  if (random.Chance(0.35)) PaintBlind(canvas, glass, random);
  if (random.Chance(0.4)) PaintPlants(canvas, glass, random);
  PaintBars(canvas, glass, frame, random.Integer(1, 3), random.Integer(1, 3));
}

void PaintShopWindow(Canvas& canvas, const PixelArea& area, const Paint& frame, Random& random) {
  Fill(canvas, area, frame);
  const PixelArea glass = Inset(area, std::max(4.0, 0.02 * area.width()));
  PaintGlass(canvas, glass, random.Chance(0.7), random);
  PaintThings(canvas, glass, random.Integer(8, 20), random);
  for (int i = random.Integer(1, 4); i > 0; --i) {  // posters
    const double width = random.Uniform(0.1, 0.25) * glass.width();
    const double x = random.Uniform(glass.left, glass.right - width);
    const double y = glass.top + random.Uniform(0.05, 0.5) * glass.height();
    PaintSign(canvas, {x, y, x + width, y + random.Uniform(0.15, 0.4) * glass.height()}, random);
  }
  PaintBars(canvas, glass, frame, random.Integer(1, 3), 1);
}

void PaintDoor(Canvas& canvas, const PixelArea& area, Random& random) {
  const Paint wood =
      random.Chance(0.6) ? VividPaint(random).Scaled(0.7) : MutedPaint(random, 30, 200);
  Fill(canvas, area, wood.Scaled(0.6));
  const PixelArea leaf = Inset(area, std::max(3.0, 0.05 * area.width()));
  Fill(canvas, leaf, wood);
  const int rows = random.Integer(2, 4);
  const int columns = random.Integer(1, 2);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const PixelArea panel{leaf.left + leaf.width() * (column + 0.14) / columns,
                            leaf.top + leaf.height() * (row + 0.12) / rows,
                            leaf.left + leaf.width() * (column + 0.86) / columns,
                            leaf.top + leaf.height() * (row + 0.88) / rows};
      const bool is_glass = row == 0 && random.Chance(0.6);
      Fill(canvas, panel,
           is_glass ? Paint{40, 50, 60, 120} : wood.Scaled(random.Uniform(0.7, 1.3)));
    }
  }
  canvas.FillDisc(leaf.right - 0.1 * leaf.width(), leaf.top + 0.55 * leaf.height(),
                  std::max(2.0, 0.04 * leaf.width()), {220, 190, 90, 0});
}

void PaintSign(Canvas& canvas, const PixelArea& area, Random& random) {
  Paint board = random.Chance(0.6) ? VividPaint(random) : MutedPaint(random, 20, 240);
  board.emission = random.Chance(0.4) ? 200 : 0;
  const bool is_bright = board.red + board.green + board.blue > 330;
  Paint ink = is_bright ? MutedPaint(random, 5, 60) : MutedPaint(random, 200, 245);
  ink.emission = board.emission;
  Fill(canvas, area, ink);
  Fill(canvas, Inset(area, std::max(1.5, 0.04 * area.height())), board);
  const double height = area.height() * random.Uniform(0.35, 0.6);
  const int letters = std::clamp(static_cast<int>(area.width() * 0.9 / (0.72 * height)), 1, 11);
  const double word_width = (letters - 1) * 0.72 * height + 0.52 * height;
  canvas.DrawWord(area.left + (area.width() - word_width) / 2,
                  area.top + (area.height() - height) / 2, height, letters, random, ink);
}

}  // namespace waymark::simulator
