// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "mapping/features/internal/row_ring.h"
#include "mapping/features/internal/sift_kernels.h"

namespace waymark::mapping::internal {

/// No extremum is sought, or followed, closer to the border of its octave than this.
constexpr int kBorder_px = 5;
/// Refinement moves by a pixel at a time and looks one pixel farther.
constexpr int kRefinementSteps = 5;
constexpr int kRefinementReach_px = kRefinementSteps + 1;

/// Smoothness of a layer in pixels of its octave: 1.6 at layer 0, twice that at layer kLayers.
double SigmaOfLayer(double layer);

/// The differences of Gaussians of one octave, as far as they still exist.
struct Differences {
  std::array<RowRing, kDifferences> rings;
  int width = 0;
  int height = 0;
};

/// An extremum of the scale space; in pixels of its octave, integers at pixel centres.
struct Extremum {
  int octave;
  int layer;  ///< the nearest, 1 to kLayers
  int column;
  int row;
  float x;         ///< refined
  float y;         ///< refined
  float sigma;     ///< refined: how smooth its octave is at its scale
  float strength;  ///< |difference| over the range of luminance
};

struct ExtremaOptions {
  double contrast_threshold = 0.01;  ///< as FeatureOptions has it
  double edge_ratio = 10;            ///< largest ratio of the two curvatures in the image
};

/// The least |difference| at a pixel for it to be looked at.
float PixelThreshold(const ExtremaOptions& options);

/// Fits a quadric around a pixel that is an extremum; nothing when the fit does not settle, is
/// weak or lies on an edge. Rows `row` +- kRefinementReach_px must exist.
/// Source: Lowe 2004, sections 4 and 4.1.
std::optional<Extremum> RefineExtremum(const Differences& differences, int octave, int row,
                                       ExtremumPlace place, const ExtremaOptions& options);

}  // namespace waymark::mapping::internal
