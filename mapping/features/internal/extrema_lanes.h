// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/features/internal/lanes.h"
#include "mapping/features/internal/sift_kernels.h"

namespace waymark::mapping::internal::WAYMARK_LANES {

struct Range {
  Floats low;
  Floats high;
};

/// Over the 3 x 3 pixels around each of kLanes pixels of one difference.
inline Range NeighbourRange(const float* const rows[3], int x) {
  Range range{Load(rows[1] + x), Load(rows[1] + x)};
#pragma GCC unroll 3
  for (int r = 0; r < 3; ++r) {
#pragma GCC unroll 3
    for (int dx = -1; dx <= 1; ++dx) {
      const Floats value = Load(rows[r] + x + dx);
      range.low = Min(range.low, value);
      range.high = Max(range.high, value);
    }
  }
  return range;
}

inline int FindExtrema(const float* const (*rows)[3], int begin, int end, float threshold,
                       ExtremumPlace* found) {
  const Floats above = Set(threshold), below = Set(-threshold);
  int count = 0;
  for (int x = begin; x < end; x += kLanes) {
    const unsigned inside = end - x >= kLanes ? (1U << kLanes) - 1 : (1U << (end - x)) - 1;
    Floats largest = Set(0);
#pragma GCC unroll 3
    for (int layer = 1; layer <= kLayers; ++layer) {
      largest = Max(largest, Abs(Load(rows[layer][1] + x)));
    }
    if (!Bits(GreaterEqual(largest, above))) continue;  // sky, walls
    Range ranges[kDifferences];
#pragma GCC unroll 5
    for (int d = 0; d < kDifferences; ++d) ranges[d] = NeighbourRange(rows[d], x);
#pragma GCC unroll 3
    for (int layer = 1; layer <= kLayers; ++layer) {
      const Floats value = Load(rows[layer][1] + x);
      const Floats high =
          Max(Max(ranges[layer - 1].high, ranges[layer].high), ranges[layer + 1].high);
      const Floats low = Min(Min(ranges[layer - 1].low, ranges[layer].low), ranges[layer + 1].low);
      const Mask extreme = Or(And(GreaterEqual(value, high), GreaterEqual(value, above)),
                              And(GreaterEqual(low, value), GreaterEqual(below, value)));
      for (unsigned bits = Bits(extreme) & inside; bits != 0; bits &= bits - 1) {
        found[count++] = {x + __builtin_ctz(bits), layer};
      }
    }
  }
  return count;
}

}  // namespace waymark::mapping::internal::WAYMARK_LANES
