// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/facade_painter.h"

#include <algorithm>
#include <cmath>

#include "examples/simulator/world/noise.h"
#include "examples/simulator/world/opening_painter.h"

namespace waymark::simulator {
namespace {

/// Converts the plan's metres (x right, z up from the foot) to texels.
class FacadeBrush {
 public:
  FacadeBrush(const FacadePlan& plan, double texels_per_m)
      : height_m_(plan.height_m), scale_(texels_per_m) {}

  PixelArea Area(double left_m, double bottom_m, double right_m, double top_m) const {
    return {left_m * scale_, (height_m_ - top_m) * scale_, right_m * scale_,
            (height_m_ - bottom_m) * scale_};
  }
  double Length(double metres) const { return metres * scale_; }

 private:
  double height_m_;
  double scale_;
};

/// Courses of bricks, stones or planks, each with its own shade.
void PaintCourses(Canvas& canvas, const Paint& wall, double width, double height, double joint,
                  double variation, Random& random) {
  int course = 0;
  for (double y = 0; y < canvas.height_px(); y += height, ++course) {
    double x = course % 2 == 0 ? 0 : -width / 2;
    while (x < canvas.width_px()) {
      const double length = width * random.Uniform(0.9, 1.1);
      canvas.FillRectangle(x + joint, y + joint, x + length, y + height,
                           wall.Scaled(1 + random.Uniform(-variation, variation)));
      x += length;
    }
  }
}

void PaintWall(Canvas& canvas, const FacadePlan& plan, const FacadeBrush& brush, const Paint& wall,
               Random& random) {
  const double joint = std::max(1.0, brush.Length(0.015));
  switch (plan.wall) {
    case WallKind::kBrick:
      PaintCourses(canvas, wall, brush.Length(random.Uniform(0.22, 0.34)),
                   brush.Length(random.Uniform(0.08, 0.13)), joint, 0.24, random);
      return;
    case WallKind::kStone:
      PaintCourses(canvas, wall, brush.Length(random.Uniform(0.5, 0.9)),
                   brush.Length(random.Uniform(0.25, 0.4)), 1.6 * joint, 0.2, random);
      return;
    case WallKind::kPlanks:
      PaintCourses(canvas, wall, brush.Length(random.Uniform(2, 4)),
                   brush.Length(random.Uniform(0.12, 0.2)), joint, 0.15, random);
      return;
    case WallKind::kPlaster:
      for (int i = 0; i < 40; ++i) {  // patches of newer plaster
        const double x = random.Uniform(0, canvas.width_px());
        const double y = random.Uniform(0, canvas.height_px());
        const double reach = brush.Length(random.Uniform(0.1, 0.7));
        canvas.FillRectangle(x, y, x + reach, y + reach * random.Uniform(0.3, 1.2),
                             wall.Scaled(random.Uniform(0.86, 1.12)));
      }
      return;
  }
}

void PaintBands(Canvas& canvas, const FacadePlan& plan, const FacadeBrush& brush,
                const Paint& trim) {
  for (const Storey& storey : plan.storeys) {
    const PixelArea band =
        brush.Area(0, storey.ceiling_m - 0.09, plan.width_m, storey.ceiling_m + 0.09);
    canvas.FillRectangle(band.left, band.top, band.right, band.bottom, trim);
    canvas.FillRectangle(band.left, band.bottom - 2, band.right, band.bottom, trim.Scaled(0.55));
  }
}

void PaintOpenings(Canvas& canvas, const FacadePlan& plan, const FacadeBrush& brush,
                   const Paint& trim, Random& random) {
  const Paint frame = MutedPaint(random, 40, 240);
  for (const Storey& storey : plan.storeys) {
    const bool is_ground = storey.floor_m == 0;
    for (const Opening& opening : storey.openings) {
      const PixelArea surround = brush.Area(opening.left_m - 0.1, storey.sill_m - 0.12,
                                            opening.right_m + 0.1, storey.head_m + 0.12);
      canvas.FillRectangle(surround.left, surround.top, surround.right, surround.bottom,
                           trim.Scaled(random.Uniform(0.9, 1.05)));
      const PixelArea area =
          brush.Area(opening.left_m, storey.sill_m, opening.right_m, storey.head_m);
      if (opening.is_door) {
        PaintDoor(canvas, area, random);
      } else if (is_ground && plan.has_shop) {
        PaintShopWindow(canvas, area, frame, random);
      } else {
        PaintWindow(canvas, area, frame, random);
      }
    }
    if (is_ground && plan.has_shop) {
      const double left = random.Uniform(0.2, 0.3 * plan.width_m);
      const double right = plan.width_m - random.Uniform(0.2, 0.3 * plan.width_m);
      PaintSign(canvas, brush.Area(left, storey.head_m + 0.2, right, storey.ceiling_m - 0.15),
                random);
    }
  }
}

/// Plaques, posters, house numbers, cables, cracks and the odd spray can.
void PaintClutter(Canvas& canvas, const FacadePlan& plan, const FacadeBrush& brush,
                  Random& random) {
  for (int i = random.Integer(4, 10); i > 0; --i) {
    const double x = random.Uniform(0.1, plan.width_m - 0.9);
    const double z =
        random.Chance(0.7) ? random.Uniform(0.8, 2.8) : random.Uniform(3, plan.height_m - 1);
    const double width = random.Uniform(0.2, 0.8);
    PaintSign(canvas, brush.Area(x, z, x + width, z + width * random.Uniform(0.4, 1.3)), random);
  }
  for (int i = random.Integer(2, 6); i > 0; --i) {  // cables and cracks
    double x = random.Uniform(0, canvas.width_px());
    double y = random.Uniform(0, canvas.height_px());
    const Paint paint = MutedPaint(random, 15, 90);
    const double width = random.Uniform(1, 3.5);
    const bool is_cable = random.Chance(0.5);
    for (int step = 0; step < 12; ++step) {
      const double dx = random.Normal(is_cable ? 4 : 18);
      const double dy = is_cable ? brush.Length(0.4) : random.Normal(18);
      canvas.DrawLine(x, y, x + dx, y + dy, width, paint);
      x += dx;
      y += dy;
    }
  }
  if (random.Chance(0.5)) {
    const double height = brush.Length(random.Uniform(0.3, 0.7));
    canvas.DrawWord(random.Uniform(0, canvas.width_px() * 0.6),
                    canvas.height_px() - brush.Length(random.Uniform(1.0, 2.0)), height,
                    random.Integer(3, 7), random, VividPaint(random));
  }
}

/// Rain leaves dark runs below sills and ledges.
void AddRuns(std::vector<float>& relief, const Canvas& canvas, Random& random) {
  const int width = canvas.width_px();
  for (int i = random.Integer(20, 60); i > 0; --i) {
    const int x0 = random.Integer(0, width - 1);
    const int y0 = random.Integer(0, canvas.height_px() - 1);
    const int reach = random.Integer(20, 220);
    const int thickness = random.Integer(2, 9);
    const float depth = random.UniformFloat(0.05, 0.2);
    for (int y = y0; y < std::min(canvas.height_px(), y0 + reach); ++y) {
      const float fade = depth * (1 - static_cast<float>(y - y0) / static_cast<float>(reach));
      for (int x = x0; x < std::min(width, x0 + thickness); ++x) {
        relief[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x)] -= fade;
      }
    }
  }
}

}  // namespace

Canvas PaintFacade(const FacadePlan& plan, double texels_per_m, Random random) {
  const FacadeBrush brush(plan, texels_per_m);
  Paint wall = MutedPaint(random, 95, 205);
  if (plan.wall == WallKind::kBrick && random.Chance(0.7)) {
    wall = {random.UniformFloat(125, 185), random.UniformFloat(70, 115),
            random.UniformFloat(55, 95), 0};
  }
  const Paint trim = MutedPaint(random, 120, 225);
  Canvas canvas(static_cast<int>(std::lround(brush.Length(plan.width_m))),
                static_cast<int>(std::lround(brush.Length(plan.height_m))), wall.Scaled(0.8));
  PaintWall(canvas, plan, brush, wall, random);
  PaintBands(canvas, plan, brush, trim);
  PaintOpenings(canvas, plan, brush, trim, random);
  PaintClutter(canvas, plan, brush, random);
  // The share of each scale decides what a feature detector finds: see README, "Realism".
  const float s = static_cast<float>(texels_per_m) / 90;
  std::vector<float> relief = MakeNoise(canvas.width_px(), canvas.height_px(),
                                        {{std::max(1.0F, 2.2F * s), 0.022F},
                                         {std::max(1.0F, 4 * s), 0.026F},
                                         {8 * s, 0.024F},
                                         {17 * s, 0.03F},
                                         {37 * s, 0.035F},
                                         {90 * s, 0.05F},
                                         {260 * s, 0.06F}},
                                        random.Bits());
  AddRuns(relief, canvas, random);
  canvas.Weather(relief);
  return canvas;
}

}  // namespace waymark::simulator
