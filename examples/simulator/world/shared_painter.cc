// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/shared_painter.h"

#include "examples/simulator/world/noise.h"
#include "examples/simulator/world/opening_painter.h"

namespace waymark::simulator {
namespace {

constexpr int kCellTexels = 112;

PixelArea Cell(int row, int column, double texels) {
  return {column * texels, row * texels, (column + 1) * texels, (row + 1) * texels};
}

void PaintBoard(Canvas& canvas, const PixelArea& area, Random& random) {
  const Paint base =
      random.Chance(0.12) ? VividPaint(random).Scaled(0.8) : MutedPaint(random, 50, 215);
  canvas.FillRectangle(area.left, area.top, area.right, area.bottom, base);
  const int kind = random.Integer(0, 3);
  for (int i = 0; i < 9; ++i) {
    const Paint shade = base.Scaled(random.Uniform(0.55, 1.25));
    const double from = area.width() * (i + 0.1) / 9;
    const double to = area.width() * (i + 0.85) / 9;
    if (kind == 0)
      canvas.FillRectangle(area.left + from, area.top, area.left + to, area.bottom, shade);
    if (kind == 1)
      canvas.FillRectangle(area.left, area.top + from, area.right, area.top + to, shade);
  }
  for (int i = random.Integer(5, 40); i > 0; --i) {
    const Paint spot = kind == 2 ? Paint{random.UniformFloat(20, 130), random.UniformFloat(60, 180),
                                         random.UniformFloat(10, 80), 0}
                                 : base.Scaled(random.Uniform(0.4, 1.4));
    const double radius = random.Uniform(1.5, kind == 2 ? 8 : 4);
    canvas.FillDisc(random.Uniform(area.left + radius, area.right - radius),
                    random.Uniform(area.top + radius, area.bottom - radius), radius, spot);
  }
}

void WeatherSheet(Canvas& canvas, float strength, Random& random) {
  canvas.Weather(MakeNoise(canvas.width_px(), canvas.height_px(),
                           {{2, 0.05F * strength},
                            {5, 0.06F * strength},
                            {14, 0.06F * strength},
                            {60, 0.06F * strength}},
                           random.Bits()));
}

}  // namespace

Canvas PaintOrnamentSheet(Random random) {
  const int side = kSheetCells * kCellTexels;
  Canvas canvas(side, side, {});
  for (int row = 0; row < kSheetCells; ++row) {
    for (int column = 0; column < kSheetCells; ++column) {
      const PixelArea area = Cell(row, column, kCellTexels);
      if (row < kSheetCells / 2) {
        PaintBoard(canvas, area, random);
      } else {
        PaintSign(canvas, area, random);
      }
    }
  }
  WeatherSheet(canvas, 1, random);
  return canvas;
}

Canvas PaintPlainSheet(Random random) {
  constexpr int kTexels = 32;
  const int side = kSheetCells * kTexels;
  Canvas canvas(side, side, {});
  for (int row = 0; row < kSheetCells; ++row) {
    for (int column = 0; column < kSheetCells; ++column) {
      const PixelArea area = Cell(row, column, kTexels);
      const Paint paint = row < kSheetCells / 4 ? MutedPaint(random, 12, 45)
                          : random.Chance(0.3)  ? VividPaint(random).Scaled(random.Uniform(0.4, 1))
                                                : MutedPaint(random, 30, 220);
      canvas.FillRectangle(area.left, area.top, area.right, area.bottom, paint);
    }
  }
  WeatherSheet(canvas, 0.3F, random);
  return canvas;
}

Canvas PaintSideWall(Random random) {
  constexpr double kBrick = 20;
  Canvas canvas(320, 320, {120, 116, 110, 0});
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 16; ++column) {
      const double x = (column + (row % 2) * 0.5) * kBrick;
      canvas.FillRectangle(x + 1, row * 8 + 1, x + kBrick, row * 8 + 8,
                           Paint{150, 105, 88, 0}.Scaled(random.Uniform(0.75, 1.2)));
    }
  }
  WeatherSheet(canvas, 0.8F, random);
  return canvas;
}

Canvas PaintRoof(Random random) {
  Canvas canvas(320, 320, {70, 50, 45, 0});
  for (int row = 0; row < 16; ++row) {
    for (int column = 0; column < 20; ++column) {
      canvas.FillRectangle(column * 16 + 1, row * 20 + 2, column * 16 + 15, row * 20 + 20,
                           Paint{130, 75, 60, 0}.Scaled(random.Uniform(0.7, 1.2)));
    }
  }
  WeatherSheet(canvas, 0.8F, random);
  return canvas;
}

}  // namespace waymark::simulator
