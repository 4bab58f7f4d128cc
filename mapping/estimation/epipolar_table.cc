// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/epipolar_table.h"

namespace waymark::mapping {
namespace {

constexpr std::size_t kLanes = 16;

struct Columns {
  const float* x1;
  const float* y1;
  const float* x2;
  const float* y2;
  const float* variance1;
  const float* variance2;
};

__attribute__((always_inline)) inline float SumTruncated(const Columns& columns, std::size_t padded,
                                                         const float* e) {
  float sums[kLanes] = {};
  for (std::size_t block = 0; block < padded; block += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t i = block + lane;
      const float x1 = columns.x1[i];
      const float y1 = columns.y1[i];
      const float x2 = columns.x2[i];
      const float y2 = columns.y2[i];
      const float line1_x = e[0] * x2 + e[1] * y2 + e[2];
      const float line1_y = e[3] * x2 + e[4] * y2 + e[5];
      const float line1_w = e[6] * x2 + e[7] * y2 + e[8];
      const float line2_x = e[0] * x1 + e[3] * y1 + e[6];
      const float line2_y = e[1] * x1 + e[4] * y1 + e[7];
      const float residual = x1 * line1_x + y1 * line1_y + line1_w;
      const float variance = (line1_x * line1_x + line1_y * line1_y) * columns.variance1[i] +
                             (line2_x * line2_x + line2_y * line2_y) * columns.variance2[i];
      const float squared = residual * residual;
      sums[lane] += squared < variance ? squared / variance : 1.0F;
    }
  }
  float sum = 0;
  for (float lane_sum : sums) sum += lane_sum;
  return sum;
}

// No "fma": the sums must not depend on the processor.
__attribute__((target("avx2"))) float SumTruncatedAvx2(const Columns& columns, std::size_t padded,
                                                       const float* essential) {
  return SumTruncated(columns, padded, essential);
}

float SumTruncatedPortable(const Columns& columns, std::size_t padded, const float* essential) {
  return SumTruncated(columns, padded, essential);
}

}  // namespace

void EpipolarTable::Add(const Match& match) {
  x1_.push_back(match.x1);
  y1_.push_back(match.y1);
  x2_.push_back(match.x2);
  y2_.push_back(match.y2);
  variance1_.push_back(match.variance1);
  variance2_.push_back(match.variance2);
  ++size_;
}

void EpipolarTable::Pad() {
  // A variance of zero is never an inlier: padding always costs 1.
  const std::size_t padded = (size_ + kLanes - 1) / kLanes * kLanes;
  for (std::vector<float>* column : {&x1_, &y1_, &x2_, &y2_, &variance1_, &variance2_}) {
    column->resize(padded, 0.0F);
  }
}

float EpipolarTable::TruncatedCost(const float essential[9]) const {
  static const auto sum = __builtin_cpu_supports("avx2") ? SumTruncatedAvx2 : SumTruncatedPortable;
  const Columns columns{x1_.data(), y1_.data(),        x2_.data(),
                        y2_.data(), variance1_.data(), variance2_.data()};
  return sum(columns, x1_.size(), essential) - static_cast<float>(x1_.size() - size_);
}

}  // namespace waymark::mapping
