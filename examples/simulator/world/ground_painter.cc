// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/ground_painter.h"

#include <algorithm>
#include <cmath>

#include "examples/simulator/world/noise.h"
#include "examples/simulator/world/opening_painter.h"

namespace waymark::simulator {
namespace {

const Paint kAsphalt{96, 96, 100, 0};
const Paint kMarking{205, 205, 200, 0};

void PaintSlabs(Canvas& canvas, const PixelArea& area, double slab_px, Random& random) {
  const Paint stone = MutedPaint(random, 120, 160);
  for (double y = area.top; y < area.bottom - 1; y += slab_px) {
    for (double x = area.left; x < area.right - 1; x += slab_px) {
      canvas.FillRectangle(x + 1, y + 1, std::min(x + slab_px, area.right),
                           std::min(y + slab_px, area.bottom),
                           stone.Scaled(random.Uniform(0.84, 1.12)));
    }
  }
}

void PaintWear(Canvas& canvas, const PixelArea& area, double texels_per_m, Random& random) {
  const double square_m = area.width() * area.height() / (texels_per_m * texels_per_m);
  const auto inside_x = [&] { return random.Uniform(area.left, area.right); };
  const auto inside_y = [&] { return random.Uniform(area.top, area.bottom); };
  for (int i = static_cast<int>(square_m / 14); i > 0; --i) {  // patches
    const double x = inside_x();
    const double y = inside_y();
    canvas.FillRectangle(x, y, std::min(area.right, x + texels_per_m * random.Uniform(0.3, 2.2)),
                         std::min(area.bottom, y + texels_per_m * random.Uniform(0.3, 1.2)),
                         kAsphalt.Scaled(random.Uniform(0.72, 1.2)));
  }
  for (int i = static_cast<int>(square_m / 3); i > 0; --i) {  // cracks
    double x = inside_x();
    double y = inside_y();
    const double lean = random.Uniform(0, 6.3);
    for (int step = 0; step < 5; ++step) {
      const double direction = lean + random.Normal(0.6);
      const double next_x = x + 0.15 * texels_per_m * std::cos(direction);
      const double next_y = y + 0.15 * texels_per_m * std::sin(direction);
      canvas.DrawLine(x, y, next_x, next_y, random.Uniform(1, 2), {52, 52, 54, 0});
      x = next_x;
      y = next_y;
    }
  }
  for (int i = static_cast<int>(square_m * 3); i > 0; --i) {  // spots, leaves, litter
    Paint spot = MutedPaint(random, 45, 190);
    if (random.Chance(0.3)) spot = {150, 120, 50, 0};
    canvas.FillDisc(inside_x(), inside_y(), texels_per_m * random.Uniform(0.012, 0.045), spot);
  }
}

void PaintCovers(Canvas& canvas, const PixelArea& area, double texels_per_m, int count,
                 Random& random) {
  for (int i = 0; i < count; ++i) {
    const double x = random.Uniform(area.left, area.right);
    const double y = random.Uniform(area.top, area.bottom);
    canvas.FillDisc(x, y, 0.36 * texels_per_m, {60, 58, 56, 0});
    for (int k = 0; k < 24; ++k) {
      const double angle = random.Uniform(0, 6.3);
      const double reach = texels_per_m * random.Uniform(0.04, 0.3);
      canvas.FillDisc(x + reach * std::cos(angle), y + reach * std::sin(angle), 0.03 * texels_per_m,
                      {105, 100, 96, 0});
    }
  }
}

void PaintMarkings(Canvas& canvas, const StreetPicture& street) {
  const double s = street.texels_per_m;
  const double middle = (street.pavement_m + street.road_m / 2) * s;
  for (double x = 5; x < street.length_m - 6; x += 4) {
    canvas.FillRectangle(x * s, middle - 0.07 * s, (x + 2) * s, middle + 0.07 * s, kMarking);
  }
  for (const double start : {0.8, street.length_m - 3.3}) {  // crossings for walkers at both ends
    for (double y = street.pavement_m + 0.4; y < street.pavement_m + street.road_m - 0.4; y += 1) {
      canvas.FillRectangle(start * s, y * s, (start + 2.5) * s, (y + 0.5) * s, kMarking);
    }
  }
}

void WeatherGround(Canvas& canvas, double texels_per_m, Random& random) {
  const auto cell = [&](double metres) {
    return std::max(1.0F, static_cast<float>(metres * texels_per_m));
  };
  canvas.Weather(MakeNoise(canvas.width_px(), canvas.height_px(),
                           {{cell(0.04), 0.045F},
                            {cell(0.09), 0.035F},
                            {cell(0.25), 0.04F},
                            {cell(0.8), 0.05F},
                            {cell(3), 0.06F}},
                           random.Bits()));
}

int Texels(double metres, double texels_per_m) {
  return static_cast<int>(std::lround(metres * texels_per_m));
}

}  // namespace

Canvas PaintStreet(const StreetPicture& street, Random random) {
  const double s = street.texels_per_m;
  const double across = street.road_m + 2 * street.pavement_m;
  Canvas canvas(Texels(street.length_m, s), Texels(across, s), kAsphalt);
  const double right = street.length_m * s;
  const double kerb0 = street.pavement_m * s;
  const double kerb1 = kerb0 + street.road_m * s;
  const PixelArea road{0, kerb0, right, kerb1};
  PaintWear(canvas, road, s, random);
  PaintMarkings(canvas, street);
  PaintCovers(canvas, road, s, static_cast<int>(street.length_m / 12), random);
  for (const PixelArea& side :
       {PixelArea{0, 0, right, kerb0}, PixelArea{0, kerb1, right, across * s}}) {
    PaintSlabs(canvas, side, s * random.Uniform(0.4, 0.7), random);
    PaintWear(canvas, side, s, random);
  }
  const double stone = 0.15 * s;
  PaintSlabs(canvas, {0, kerb0 - stone, right, kerb0}, stone, random);
  PaintSlabs(canvas, {0, kerb1, right, kerb1 + stone}, stone, random);
  WeatherGround(canvas, s, random);
  return canvas;
}

Canvas PaintCrossing(const StreetPicture& street, Random random) {
  const double s = street.texels_per_m;
  const double side = (street.road_m + 2 * street.pavement_m) * s;
  Canvas canvas(Texels(side / s, s), Texels(side / s, s), kAsphalt);
  const PixelArea all{0, 0, side, side};
  PaintWear(canvas, all, s, random);
  PaintCovers(canvas, all, s, 2, random);
  const double corner = street.pavement_m * s;
  for (const double x : {0.0, side - corner}) {
    for (const double y : {0.0, side - corner}) {
      PaintSlabs(canvas, {x, y, x + corner, y + corner}, 0.5 * s, random);
    }
  }
  WeatherGround(canvas, s, random);
  return canvas;
}

}  // namespace waymark::simulator
