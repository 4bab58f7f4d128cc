// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/features/internal/lanes.h"
#include "mapping/features/internal/sift_kernels.h"

namespace waymark::mapping::internal::WAYMARK_LANES {

constexpr int kTileVectors = 4;  ///< as many sums in flight as an addition takes cycles
constexpr int kTile = kTileVectors * kLanes;
static_assert(kRowGranule % kTile == 0);

inline int RoundUp(int length) { return (length + kRowGranule - 1) / kRowGranule * kRowGranule; }

/// Fills `radius` floats on both sides of a row by mirroring about its end pixels.
inline void MirrorEnds(float* row, int width, int radius) {
  const auto mirrored = [&](int i) {
    const int period = width > 1 ? 2 * width - 2 : 1;
    i = (i % period + period) % period;
    return i < width ? i : period - i;
  };
  for (int i = 1; i <= radius; ++i) {
    row[-i] = row[mirrored(-i)];
    row[width - 1 + i] = row[mirrored(width - 1 + i)];
  }
}

inline void DoubleRow(const std::uint8_t* in, int width, const float* taps, int radius,
                      float* scratch, float* out) {
  float* const row = scratch + radius;
  for (int x = 0; x < width; ++x) row[x] = in[x];
  for (int x = width + radius; x < RoundUp(width) + radius; ++x) row[x] = 0;
  MirrorEnds(row, width, radius);
  for (int x = 0; 2 * x < RoundUp(2 * width); x += kLanes) {
    Floats even = Set(0), odd = even;
    for (int t = 0; t <= 2 * radius; ++t) {
      const Floats value = Load(scratch + x + t);
      even += Set(taps[t]) * value;
      odd += Set(taps[2 * radius - t]) * value;
    }
    StoreInterleaved(out + 2 * x, even, odd);
  }
}

inline void FilterColumns(const float* const* rows, const float* taps, int count, int step,
                          int width, float* out) {
  for (int x = 0; x < width; x += kTile) {
    Floats sum[kTileVectors] = {};
    for (int t = 0; t < count; ++t) {
      const Floats tap = Set(taps[step * t]);
#pragma GCC unroll 4
      for (int v = 0; v < kTileVectors; ++v) sum[v] += tap * Load(rows[t] + x + v * kLanes);
    }
#pragma GCC unroll 4
    for (int v = 0; v < kTileVectors; ++v) Store(out + x + v * kLanes, sum[v]);
  }
}

/// One tile of a symmetric sum; before(j) and after(j) are what lies j steps from the middle.
template <typename Before, typename After>
inline void BlurTile(const float* middle, const float* taps, int radius, const Before& before,
                     const After& after, float* out) {
  Floats sum[kTileVectors];
#pragma GCC unroll 4
  for (int v = 0; v < kTileVectors; ++v) sum[v] = Set(taps[0]) * Load(middle + v * kLanes);
  for (int j = 1; j <= radius; ++j) {
    const Floats tap = Set(taps[j]);
    const float* const a = before(j);
    const float* const b = after(j);
#pragma GCC unroll 4
    for (int v = 0; v < kTileVectors; ++v) {
      sum[v] += tap * (Load(a + v * kLanes) + Load(b + v * kLanes));
    }
  }
#pragma GCC unroll 4
  for (int v = 0; v < kTileVectors; ++v) Store(out + v * kLanes, sum[v]);
}

inline void BlurRows(const float* const* rows, int count, const float* taps, int radius, int width,
                     float* scratch, float* const* out) {
  // A tile's columns of all rows stay in the first cache while every output row passes over them.
  const int row_length = RoundUp(2 * kRowGranule + width + 2 * radius);
  float* const middle = scratch + kRowGranule;
  for (int x = 0; x < width; x += kTile) {
    for (int i = 0; i < count; ++i) {
      const float* const* const centre = rows + radius + i;
      BlurTile(
          *centre + x, taps, radius, [&](int j) { return centre[-j] + x; },
          [&](int j) { return centre[j] + x; }, middle + i * row_length + x);
    }
  }
  for (int i = 0; i < count; ++i) {
    float* const row = middle + i * row_length;
    MirrorEnds(row, width, radius);
    for (int x = 0; x < width; x += kTile) {
      BlurTile(
          row + x, taps, radius, [&](int j) { return row + x - j; },
          [&](int j) { return row + x + j; }, out[i] + x);
    }
  }
}

inline void Subtract(const float* minuend, const float* subtrahend, int width, float* out) {
  for (int x = 0; x < width; x += kLanes) Store(out + x, Load(minuend + x) - Load(subtrahend + x));
}

}  // namespace waymark::mapping::internal::WAYMARK_LANES
