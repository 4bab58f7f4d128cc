// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/denoise.h"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace waymark::simulator {
namespace {

constexpr int kReach = 2;        // pixels
constexpr float kSpread = 1.5F;  // pixels, of the weights by distance
constexpr float kTolerance = 2;  // weights by difference are this many sigmas wide

/// Differences are summed over the channels.
std::array<float, 3 * 255 + 1> WeightsByDifference(float sigma) {
  std::array<float, 3 * 255 + 1> weights{};
  const float width = 3 * kTolerance * sigma;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const float ratio = static_cast<float>(i) / width;
    weights[i] = std::exp(-ratio * ratio / 2);
  }
  return weights;
}

std::array<float, 2 * kReach * kReach + 1> WeightsBySquaredDistance() {
  std::array<float, 2 * kReach * kReach + 1> weights{};
  for (std::size_t i = 0; i < weights.size(); ++i) {
    weights[i] = std::exp(-static_cast<float>(i) / (2 * kSpread * kSpread));
  }
  return weights;
}

}  // namespace

ColourImage Denoise(const ColourImage& noisy, float sigma) {
  const auto by_difference = WeightsByDifference(sigma);
  const auto by_distance = WeightsBySquaredDistance();
  ColourImage smooth = noisy;
  const auto pixel = [&](int column, int row) {
    return noisy.values.data() + 3 * (static_cast<std::ptrdiff_t>(row) * noisy.width_px + column);
  };
  for (int row = 0; row < noisy.height_px; ++row) {
    for (int column = 0; column < noisy.width_px; ++column) {
      const std::uint8_t* own = pixel(column, row);
      Eigen::Array3f sum(0, 0, 0);
      float total = 0;
      for (int y = std::max(0, row - kReach); y <= std::min(noisy.height_px - 1, row + kReach);
           ++y) {
        for (int x = std::max(0, column - kReach);
             x <= std::min(noisy.width_px - 1, column + kReach); ++x) {
          const std::uint8_t* other = pixel(x, y);
          const int difference = std::abs(own[0] - other[0]) + std::abs(own[1] - other[1]) +
                                 std::abs(own[2] - other[2]);
          const int squares = (x - column) * (x - column) + (y - row) * (y - row);
          const float weight = by_difference[static_cast<std::size_t>(difference)] *
                               by_distance[static_cast<std::size_t>(squares)];
          sum += weight * Eigen::Array3f(other[0], other[1], other[2]);
          total += weight;
        }
      }
      for (int c = 0; c < 3; ++c) {
        smooth.values[static_cast<std::size_t>(own - noisy.values.data() + c)] =
            static_cast<std::uint8_t>(sum[c] / total + 0.5F);
      }
    }
  }
  return smooth;
}

}  // namespace waymark::simulator
