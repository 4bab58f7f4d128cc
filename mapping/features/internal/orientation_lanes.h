// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/features/internal/lanes.h"
#include "mapping/features/internal/sift_kernels.h"

namespace waymark::mapping::internal::WAYMARK_LANES {

/// The direction of (x, y) in turns, in [0, 1], from +x towards +y; off by at most 1.2e-5 rad.
/// Nought for (0, 0). The polynomial is the minimax fit of atan(z) / (2 pi z) in z^2 on [0, 1].
inline Floats Turns(Floats x, Floats y) {
  const Floats along = Abs(x), across = Abs(y);
  const Floats z = Min(along, across) / Max(Max(along, across), Set(1e-30F));
  const Floats z2 = z * z;
  Floats turns = z2 * 0.00331760296F - 0.0135530542F;
  turns = turns * z2 + 0.0286732423F;
  turns = turns * z2 - 0.0525696393F;
  turns = (turns * z2 + 0.159133669F) * z;
  turns = Select(GreaterEqual(along, across), turns, 0.25F - turns);
  turns = Select(GreaterEqual(x, Set(0)), turns, 0.5F - turns);
  return Select(GreaterEqual(y, Set(0)), turns, 1.0F - turns);
}

/// Adds bin by bin into four histograms in turn: an addition need not wait for the one before.
struct FourHistograms {
  float sums[4][kOrientationBins + 1] = {};  ///< the last bin is the first
};

inline void AddOrientationRow(const float* above, const float* here, const float* below, int count,
                              const float* weights, float row_weight, FourHistograms& histograms) {
  constexpr int kLongest = 2 * kMaxOrientationRadius + 1 + kLanes;
  alignas(64) float values[kLongest];
  alignas(64) std::int32_t bins[kLongest];
  for (int i = 0; i < count; i += kLanes) {
    const Floats dx = Load(here + i + 1) - Load(here + i - 1);
    const Floats dy = Load(below + i) - Load(above + i);
    Store(values + i, Sqrt(dx * dx + dy * dy) * (Load(weights + i) * row_weight));
    Store(bins + i, ToInts(Turns(dx, dy) * static_cast<float>(kOrientationBins) + 0.5F));
  }
  for (int i = 0; i < count; ++i) histograms.sums[i & 3][bins[i]] += values[i];
}

inline int Larger(int a, int b) { return a > b ? a : b; }
inline int Smaller(int a, int b) { return a < b ? a : b; }

inline void AddOrientations(const Plane& plane, int column, int row, int radius,
                            const float* weights, float* histogram) {
  FourHistograms histograms;
  const int x = Larger(column - radius, 1);
  const int count = Smaller(column + radius, plane.width - 2) - x + 1;
  for (int y = Larger(row - radius, 1); y <= Smaller(row + radius, plane.height - 2); ++y) {
    const float* const here = plane.data + y * plane.stride + x;
    AddOrientationRow(here - plane.stride, here, here + plane.stride, count,
                      weights + (x - column + radius), weights[y - row + radius], histograms);
  }
  const auto& sums = histograms.sums;
  const auto total = [&](int bin) {
    return (sums[0][bin] + sums[1][bin]) + (sums[2][bin] + sums[3][bin]);
  };
  for (int bin = 0; bin < kOrientationBins; ++bin) histogram[bin] = total(bin);
  histogram[0] += total(kOrientationBins);
}

}  // namespace waymark::mapping::internal::WAYMARK_LANES
