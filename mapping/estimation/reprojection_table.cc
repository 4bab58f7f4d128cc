// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/reprojection_table.h"

namespace waymark::mapping {
namespace {

constexpr std::size_t kLanes = 16;

struct Columns {
  const float* x;
  const float* y;
  const float* z;
  const float* u;
  const float* v;
  const float* scale_u;
  const float* scale_v;
};

// Sixteen independent sums keep the compiler free to use vector registers of any width, and the
// result the same on each of them.
__attribute__((always_inline)) inline float SumTruncated(const Columns& columns, std::size_t padded,
                                                         const float* pose) {
  float sums[kLanes] = {};
  for (std::size_t block = 0; block < padded; block += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t i = block + lane;
      const float x = columns.x[i];
      const float y = columns.y[i];
      const float z = columns.z[i];
      const float in_x = pose[0] * x + pose[1] * y + pose[2] * z + pose[3];
      const float in_y = pose[4] * x + pose[5] * y + pose[6] * z + pose[7];
      const float in_z = pose[8] * x + pose[9] * y + pose[10] * z + pose[11];
      const float inverse = 1.0F / in_z;
      const float du = (in_x * inverse - columns.u[i]) * columns.scale_u[i];
      const float dv = (in_y * inverse - columns.v[i]) * columns.scale_v[i];
      const float squared = du * du + dv * dv;
      const float truncated = squared < 1.0F ? squared : 1.0F;  // also for not-a-number
      sums[lane] += in_z > 1e-6F ? truncated : 1.0F;
    }
  }
  float sum = 0;
  for (float lane_sum : sums) sum += lane_sum;
  return sum;
}

// No "fma": the sums must not depend on the processor.
__attribute__((target("avx2"))) float SumTruncatedAvx2(const Columns& columns, std::size_t padded,
                                                       const float* pose) {
  return SumTruncated(columns, padded, pose);
}

float SumTruncatedPortable(const Columns& columns, std::size_t padded, const float* pose) {
  return SumTruncated(columns, padded, pose);
}

}  // namespace

void ReprojectionTable::Add(float x, float y, float z, float u, float v, float scale_u,
                            float scale_v) {
  x_.push_back(x);
  y_.push_back(y);
  z_.push_back(z);
  u_.push_back(u);
  v_.push_back(v);
  scale_u_.push_back(scale_u);
  scale_v_.push_back(scale_v);
  ++size_;
}

void ReprojectionTable::Pad() {
  const std::size_t padded = (size_ + kLanes - 1) / kLanes * kLanes;
  for (std::vector<float>* column : {&x_, &y_, &z_, &u_, &v_, &scale_u_, &scale_v_}) {
    column->resize(padded, 0.0F);
  }
  // Far from anything the camera could see: every pose gives the padding a cost of 1.
  for (std::size_t i = size_; i < padded; ++i) {
    u_[i] = 1e9F;
    scale_u_[i] = 1e9F;
  }
}

float ReprojectionTable::TruncatedCost(const float pose[12]) const {
  const Columns columns{x_.data(), y_.data(),       z_.data(),      u_.data(),
                        v_.data(), scale_u_.data(), scale_v_.data()};
  static const auto sum = __builtin_cpu_supports("avx2") ? SumTruncatedAvx2 : SumTruncatedPortable;
  return sum(columns, x_.size(), pose) - static_cast<float>(x_.size() - size_);
}

}  // namespace waymark::mapping
