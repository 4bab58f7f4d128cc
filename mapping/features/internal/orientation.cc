// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/orientation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace waymark::mapping::internal {
namespace {

constexpr float kWindowSigmas = 1.5F;  ///< the window's sigma, in the extremum's
constexpr float kWindowReach = 3;      ///< where it is cut off, in its own sigmas
constexpr float kPeakShare = 0.8F;

using Histogram = std::array<float, kOrientationBins>;

Histogram GatherHistogram(const Plane& layer, const Extremum& extremum,
                          const SiftKernels& kernels) {
  const float sigma = kWindowSigmas * extremum.sigma;
  const int radius =
      std::min(static_cast<int>(std::lround(kWindowReach * sigma)), kMaxOrientationRadius);
  std::array<float, 2 * kMaxOrientationRadius + 1 + kRowSlack> weights{};
  for (int d = 0; d <= radius; ++d) {
    const float z = static_cast<float>(d) / sigma;
    weights[radius + d] = weights[radius - d] = std::exp(-z * z / 2);
  }
  Histogram histogram;
  kernels.add_orientations(layer, extremum.column, extremum.row, radius, weights.data(),
                           histogram.data());
  return histogram;
}

float At(const Histogram& histogram, int bin) {
  return histogram[(bin + kOrientationBins) % kOrientationBins];
}

Histogram Smooth(const Histogram& rough) {
  Histogram smooth;
  for (int bin = 0; bin < kOrientationBins; ++bin) {
    smooth[bin] = (At(rough, bin - 2) + At(rough, bin + 2)) * (1.0F / 16) +
                  (At(rough, bin - 1) + At(rough, bin + 1)) * (4.0F / 16) +
                  rough[bin] * (6.0F / 16);
  }
  return smooth;
}

}  // namespace

std::span<const float> FindOrientations_rad(const Plane& layer, const Extremum& extremum,
                                            const SiftKernels& kernels, OrientationRoom& room) {
  const Histogram histogram = Smooth(GatherHistogram(layer, extremum, kernels));
  const float least = kPeakShare * *std::max_element(histogram.begin(), histogram.end());
  std::size_t count = 0;
  for (int bin = 0; bin < kOrientationBins; ++bin) {
    const float before = At(histogram, bin - 1), here = histogram[bin],
                after = At(histogram, bin + 1);
    if (!(here > before && here > after && here >= least)) continue;
    const float peak =
        static_cast<float>(bin) + 0.5F * (before - after) / (before - 2 * here + after);
    const float turns = peak / kOrientationBins;
    room[count++] = (turns - std::floor(turns)) * 2 * std::numbers::pi_v<float>;
  }
  std::sort(room.begin(), room.begin() + count);
  return std::span(room).first(count);
}

}  // namespace waymark::mapping::internal
