// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "mapping/features/internal/extrema.h"
#include "mapping/features/internal/row_ring.h"
#include "mapping/features/internal/sift_kernels.h"

namespace waymark::mapping::internal {

/// Makes one octave after the other, and of an octave all levels at once from top to bottom: each
/// level a few rows behind the one it is blurred from, the search for extrema behind the last. So
/// rows are still in the cache when they are needed, and only the layers that orientations and
/// descriptors are taken from are ever kept whole. Thread-compatible.
class OctaveBuilder {
 public:
  OctaveBuilder(const ExtremaOptions& options, const SiftKernels& kernels);

  /// Floats of working memory that octaves of this width need.
  std::size_t WorkingSize(int width) const;

  /// Makes rows of level 0, asked for in order.
  using MakeRow = std::function<void(int y, float* out)>;

  /// Fills `layers` (levels 1 to kLayers, all of one size) and appends to `extrema`.
  void Build(int octave, const MakeRow& make_row, const std::array<Plane, kLayers>& layers,
             float* working, std::vector<Extremum>& extrema);

 private:
  void Place(const std::array<Plane, kLayers>& layers, float* working);
  bool MakeStrip(int level, const MakeRow& make_row);
  void BlurStrip(int level, int begin, int end);
  void SubtractRows(int begin, int end);
  void Scan(int octave, int end, std::vector<Extremum>& extrema);

  const ExtremaOptions options_;
  const SiftKernels& kernels_;
  std::array<std::vector<float>, kLevels> taps_;
  std::array<int, kLevels> ring_capacity_{};

  // The octave that is being made.
  int width_ = 0;
  int height_ = 0;
  std::array<RowRing, kLevels> levels_;
  std::array<int, kLevels> made_{};  ///< rows of each level
  Differences differences_;
  int scanned_ = 0;  ///< rows searched for extrema
  float* scratch_ = nullptr;
  std::vector<ExtremumPlace> found_;
};

}  // namespace waymark::mapping::internal
