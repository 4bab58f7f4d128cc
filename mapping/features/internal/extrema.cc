// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/extrema.h"

#include <cmath>

namespace waymark::mapping::internal {
namespace {

constexpr double kWhite = 255;

struct Vector {
  double x, y, s;
};

/// Value, gradient and Hessian of the differences at a pixel of a layer.
struct Quadric {
  double value;
  Vector gradient;
  double xx, yy, ss, xy, xs, ys;
};

Quadric FitQuadric(const Differences& differences, int layer, int row, int column) {
  const auto at = [&](int ds, int dy, int dx) -> double {
    return differences.rings[layer + ds].Row(row + dy)[column + dx];
  };
  const double middle = at(0, 0, 0);
  const auto cross = [](double pp, double pm, double mp, double mm) {
    return (pp - pm - mp + mm) / 4;
  };
  return {
      .value = middle,
      .gradient = {(at(0, 0, 1) - at(0, 0, -1)) / 2, (at(0, 1, 0) - at(0, -1, 0)) / 2,
                   (at(1, 0, 0) - at(-1, 0, 0)) / 2},
      .xx = at(0, 0, 1) + at(0, 0, -1) - 2 * middle,
      .yy = at(0, 1, 0) + at(0, -1, 0) - 2 * middle,
      .ss = at(1, 0, 0) + at(-1, 0, 0) - 2 * middle,
      .xy = cross(at(0, 1, 1), at(0, 1, -1), at(0, -1, 1), at(0, -1, -1)),
      .xs = cross(at(1, 0, 1), at(1, 0, -1), at(-1, 0, 1), at(-1, 0, -1)),
      .ys = cross(at(1, 1, 0), at(1, -1, 0), at(-1, 1, 0), at(-1, -1, 0)),
  };
}

/// Where the quadric's gradient is nought, by Cramer's rule.
std::optional<Vector> StationaryPoint(const Quadric& q) {
  const double cxx = q.yy * q.ss - q.ys * q.ys, cxy = q.xs * q.ys - q.xy * q.ss,
               cxs = q.xy * q.ys - q.xs * q.yy, cyy = q.xx * q.ss - q.xs * q.xs,
               cys = q.xy * q.xs - q.xx * q.ys, css = q.xx * q.yy - q.xy * q.xy;
  const double determinant = q.xx * cxx + q.xy * cxy + q.xs * cxs;
  if (std::abs(determinant) < 1e-12) return std::nullopt;
  const Vector& g = q.gradient;
  return Vector{-(cxx * g.x + cxy * g.y + cxs * g.s) / determinant,
                -(cxy * g.x + cyy * g.y + cys * g.s) / determinant,
                -(cxs * g.x + cys * g.y + css * g.s) / determinant};
}

bool LiesOnEdge(const Quadric& q, double ratio) {
  const double trace = q.xx + q.yy, determinant = q.xx * q.yy - q.xy * q.xy;
  return determinant <= 0 || trace * trace * ratio >= (ratio + 1) * (ratio + 1) * determinant;
}

int Step(double offset) { return offset > 0.5 ? 1 : offset < -0.5 ? -1 : 0; }

}  // namespace

double SigmaOfLayer(double layer) { return 1.6 * std::exp2(layer / kLayers); }

float PixelThreshold(const ExtremaOptions& options) {
  return static_cast<float>(0.5 * options.contrast_threshold / kLayers * kWhite);
}

std::optional<Extremum> RefineExtremum(const Differences& differences, int octave, int row,
                                       ExtremumPlace place, const ExtremaOptions& options) {
  int column = place.column, layer = place.layer;
  for (int step = 0; step < kRefinementSteps; ++step) {
    const Quadric quadric = FitQuadric(differences, layer, row, column);
    const std::optional<Vector> offset = StationaryPoint(quadric);
    if (!offset) return std::nullopt;
    if (Step(offset->x) == 0 && Step(offset->y) == 0 && Step(offset->s) == 0) {
      const Vector& g = quadric.gradient;
      const double strength =
          std::abs(quadric.value + (g.x * offset->x + g.y * offset->y + g.s * offset->s) / 2) /
          kWhite;
      if (strength * kLayers < options.contrast_threshold) return std::nullopt;
      if (LiesOnEdge(quadric, options.edge_ratio)) return std::nullopt;
      return Extremum{.octave = octave,
                      .layer = layer,
                      .column = column,
                      .row = row,
                      .x = static_cast<float>(column + offset->x),
                      .y = static_cast<float>(row + offset->y),
                      .sigma = static_cast<float>(SigmaOfLayer(layer + offset->s)),
                      .strength = static_cast<float>(strength)};
    }
    column += Step(offset->x);
    row += Step(offset->y);
    layer += Step(offset->s);
    if (layer < 1 || layer > kLayers || column < kBorder_px ||
        column >= differences.width - kBorder_px || row < kBorder_px ||
        row >= differences.height - kBorder_px) {
      return std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace waymark::mapping::internal
