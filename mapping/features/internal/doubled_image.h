// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/features/internal/row_ring.h"
#include "mapping/features/internal/sift_kernels.h"

namespace waymark::mapping::internal {

/// An 8-bit image that somebody else keeps.
struct ImageView {
  const std::uint8_t* pixels;
  std::ptrdiff_t stride;
  int width;
  int height;
};

/// Floats from one row of a working image to the next: whole granules, room for a vector that is
/// read past the end, and an odd number of cache lines, so that rows do not share cache sets.
std::ptrdiff_t RowStride(int width);

/// The image at twice its resolution and smoothed, row after row from the top. Both in one step:
/// the Gaussian is evaluated a quarter pixel to either side of the pixels.
class DoubledImage {
 public:
  DoubledImage(const ImageView& image, double sigma_px, const SiftKernels& kernels);

  int width() const { return 2 * image_.width; }
  int height() const { return 2 * image_.height; }

  /// Floats of working memory that Start needs.
  std::size_t WorkingSize() const;
  void Start(float* working);
  /// Rows must be asked for in order.
  void MakeRow(int y, float* out);

 private:
  const ImageView image_;
  const SiftKernels& kernels_;
  const std::vector<float> taps_;
  const int radius_;
  RowRing wide_;  ///< rows of the image, doubled along x
  int made_ = 0;  ///< rows of wide_
  float* scratch_ = nullptr;
};

}  // namespace waymark::mapping::internal
