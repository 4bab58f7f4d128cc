// SPDX-License-Identifier: Apache-2.0
#pragma once

// Read by code for wider registers too: nothing but plain types here.
#include <cstddef>
#include <cstdint>

namespace waymark::mapping::internal {

/// One level of the scale space. Rows are padded: see kRowGranule.
struct Plane {
  const float* data = nullptr;
  std::ptrdiff_t stride = 0;  ///< floats from row to row
  int width = 0;
  int height = 0;
};

/// Kernels write and read rows up to the next multiple of this, and read one more vector behind.
constexpr int kRowGranule = 64;
constexpr int kRowSlack = 16;

/// Layers of an octave that extrema are sought in, and what they need around them.
constexpr int kLayers = 3;
constexpr int kDifferences = kLayers + 2;
constexpr int kLevels = kLayers + 3;

constexpr int kOrientationBins = 36;
/// Rows and columns of the upright square around a keypoint that its orientation is taken from.
constexpr int kMaxOrientationRadius = 31;
constexpr int kDescriptorLength = 128;

struct ExtremumPlace {
  std::int32_t column;
  std::int32_t layer;  ///< 1 to kLayers
};

/// The turned square around a keypoint that its descriptor is taken from; in pixels of `plane`,
/// integers at pixel centres.
struct DescriptorWindow {
  Plane plane;
  float x;
  float y;
  float cosine;      ///< of the orientation, clockwise from +x
  float sine;        ///< of the orientation
  float cell_width;  ///< side of one of its 4 x 4 cells
};

/// The inner loops of SIFT for one set of vector instructions. All sets give identical bytes: no
/// fused multiply-add, and every sum has one order that does not depend on the register's width.
struct SiftKernels {
  const char* name;

  /// A row of bytes, twice as long: out[2 i] = sum of taps[t] in[i + t - radius], and
  /// out[2 i + 1] the same with the taps in reverse order. Mirrored at the ends.
  /// `scratch`: width + 2 radius + 2 kRowGranule floats.
  void (*double_row)(const std::uint8_t* in, int width, const float* taps, int radius,
                     float* scratch, float* out);

  /// out[x] = sum of taps[t] rows[t][x], with a step through the taps of 1 or -1.
  void (*filter_columns)(const float* const* rows, const float* taps, int count, int step,
                         int width, float* out);

  /// Symmetric blur of `count` rows that lie below each other: rows[radius + i] is the centre of
  /// out[i]; taps[0] is the middle one. Mirrored at the ends of rows.
  /// `scratch`: 2 kRowGranule + width + 2 radius floats, rounded up to kRowGranule, for each row.
  void (*blur_rows)(const float* const* rows, int count, const float* taps, int radius, int width,
                    float* scratch, float* const* out);

  void (*subtract)(const float* minuend, const float* subtrahend, int width, float* out);

  /// Pixels in [begin, end) that are no smaller (or no larger) than their 26 neighbours and
  /// farther than `threshold` from nought. rows[difference][0, 1, 2]: above, here, below.
  /// Returns their number, at most kLayers (end - begin); in no particular order.
  int (*find_extrema)(const float* const (*rows)[3], int begin, int end, float threshold,
                      ExtremumPlace* found);

  /// Adds up gradient magnitudes by direction, clockwise from +x, around a pixel. Pixels at the
  /// image's border have no gradient. weights[d + radius]: the factor for distance d in x or y.
  void (*add_orientations)(const Plane& plane, int column, int row, int radius,
                           const float* weights, float* histogram);

  /// The descriptor's bytes as `Descriptor` defines them.
  void (*describe)(const DescriptorWindow& window, std::uint8_t* descriptor);
};

// Only for SupportedSiftKernels(): the first two end the process on processors without the
// instructions.
SiftKernels SiftKernelsAvx512();
SiftKernels SiftKernelsAvx2();
SiftKernels SiftKernelsPortable();

}  // namespace waymark::mapping::internal
