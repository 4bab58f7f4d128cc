// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/doubled_image.h"

#include <algorithm>

#include "mapping/features/internal/gaussian.h"

namespace waymark::mapping::internal {
namespace {

/// Pixel 2 i of the doubled image lies a quarter pixel before pixel i.
constexpr double kShift_px = 0.25;

}  // namespace

std::ptrdiff_t RowStride(int width) {
  return (width + kRowGranule - 1) / kRowGranule * kRowGranule + kRowSlack;
}

DoubledImage::DoubledImage(const ImageView& image, double sigma_px, const SiftKernels& kernels)
    : image_(image),
      kernels_(kernels),
      taps_(ShiftedTaps(sigma_px, kShift_px)),
      radius_(static_cast<int>(taps_.size() / 2)) {
  wide_.stride = RowStride(width());
  wide_.capacity = 2 * radius_ + 1;
}

std::size_t DoubledImage::WorkingSize() const {
  return static_cast<std::size_t>(wide_.stride * wide_.capacity + image_.width + 2 * radius_ +
                                  2 * kRowGranule);
}

void DoubledImage::Start(float* working) {
  wide_.data = working;
  scratch_ = working + wide_.stride * wide_.capacity;
  made_ = 0;
}

void DoubledImage::MakeRow(int y, float* out) {
  const int centre = y / 2;
  for (; made_ <= std::min(centre + radius_, image_.height - 1); ++made_) {
    kernels_.double_row(image_.pixels + made_ * image_.stride, image_.width, taps_.data(), radius_,
                        scratch_, wide_.Row(made_));
  }
  std::vector<const float*> rows;
  for (int t = -radius_; t <= radius_; ++t) {
    rows.push_back(wide_.Row(MirroredIndex(centre + t, image_.height)));
  }
  const int count = static_cast<int>(taps_.size());
  const bool before = y % 2 == 0;
  kernels_.filter_columns(rows.data(), before ? taps_.data() : taps_.data() + count - 1, count,
                          before ? 1 : -1, width(), out);
}

}  // namespace waymark::mapping::internal
