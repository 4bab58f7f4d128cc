// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/sift_kernels.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "mapping/features/internal/gaussian.h"
#include "mapping/features/internal/sift.h"
#include "mapping/features/internal/sift_kernel_sets.h"

namespace waymark::mapping::internal {
namespace {

/// Noise of several sizes: full of extrema of every scale, up to the border.
std::vector<std::uint8_t> Texture(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(-1, 1);
  std::vector<float> sum(static_cast<std::size_t>(width * height));
  for (const int cell : {1, 3, 8, 21}) {
    const int columns = width / cell + 2;
    std::vector<float> grid(static_cast<std::size_t>(columns * (height / cell + 2)));
    for (float& g : grid) g = value(random);
    for (int i = 0; i < width * height; ++i) {
      sum[i] += grid[i / width / cell * columns + i % width / cell];
    }
  }
  std::vector<std::uint8_t> pixels;
  for (const float s : sum) {
    pixels.push_back(static_cast<std::uint8_t>(std::clamp(128 + 40 * s, 0.0F, 255.0F)));
  }
  return pixels;
}

class EverySet : public testing::TestWithParam<SiftKernels> {};

TEST_P(EverySet, GivesTheBytesOfThePortableOne) {
  for (const auto& [width, height] :
       {std::pair(97, 61), {64, 64}, {200, 33}, {6, 300}, {300, 7}, {131, 100}}) {
    const auto pixels = Texture(width, height, 1);
    const ImageView image{pixels.data(), width, width, height};
    const ScaleSpaceOptions options{.smoothing_px = 0.8, .extrema = {}};
    const auto expected = ExtractSift(image, options, 1000, SupportedSiftKernels().back());
    const auto found = ExtractSift(image, options, 1000, GetParam());
    ASSERT_TRUE(expected.ok() && found.ok());
    ASSERT_EQ(found->keypoints.size(), expected->keypoints.size()) << width << " x " << height;
    EXPECT_EQ(found->descriptors, expected->descriptors);
    const auto same = [](const Keypoint& a, const Keypoint& b) {
      return a.x_px == b.x_px && a.y_px == b.y_px && a.scale_px == b.scale_px &&
             a.angle_rad == b.angle_rad;
    };
    EXPECT_TRUE(std::ranges::equal(found->keypoints, expected->keypoints, same));
    EXPECT_GT(found->keypoints.size(), width * height > 5000 ? 20 : 0) << width << " x " << height;
  }
}

TEST_P(EverySet, BlursAsTheSumsSay) {
  constexpr int kWidth = 50, kRows = 3, kStride = 128;
  const std::vector<float> taps = SymmetricTaps(1.7);
  const int radius = static_cast<int>(taps.size()) - 1;
  std::mt19937 random(2);
  std::uniform_real_distribution<float> value(0, 255);
  std::vector<float> in(static_cast<std::size_t>(kStride * (kRows + 2 * radius)));
  for (float& v : in) v = value(random);
  std::vector<const float*> rows;
  for (int y = 0; y < kRows + 2 * radius; ++y) rows.push_back(in.data() + y * kStride);
  std::vector<float> out(kRows * kStride), scratch(kRows * 4 * kRowGranule);
  float* const outs[kRows] = {out.data(), out.data() + kStride, out.data() + 2 * kStride};
  GetParam().blur_rows(rows.data(), kRows, taps.data(), radius, kWidth, scratch.data(), outs);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      double sum = 0;
      for (int dy = -radius; dy <= radius; ++dy) {
        for (int dx = -radius; dx <= radius; ++dx) {
          sum += static_cast<double>(taps[std::abs(dx)]) * taps[std::abs(dy)] *
                 rows[y + radius + dy][MirroredIndex(x + dx, kWidth)];
        }
      }
      ASSERT_NEAR(outs[y][x], sum, 1e-3) << x << " " << y;
    }
  }
}

TEST_P(EverySet, SortsGradientsByDirection) {
  // A plane that ascends in one direction has all its gradients there.
  constexpr int kSide = 64;
  std::vector<float> weights(2 * 5 + 1 + kRowSlack);
  std::fill_n(weights.begin(), 11, 1.0F);
  for (int bin = 0; bin < kOrientationBins; ++bin) {
    const double direction_rad = 2 * std::numbers::pi * bin / kOrientationBins;
    std::vector<float> pixels(kSide * (kSide + kRowGranule));
    const Plane plane{pixels.data(), kSide + kRowGranule, kSide, kSide};
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        pixels[y * plane.stride + x] =
            static_cast<float>(x * std::cos(direction_rad) + y * std::sin(direction_rad));
      }
    }
    float histogram[kOrientationBins];
    GetParam().add_orientations(plane, 30, 30, 5, weights.data(), histogram);
    EXPECT_NEAR(histogram[bin], 2 * 11 * 11, 0.01) << bin;
    GetParam().add_orientations(plane, 0, kSide - 1, 5, weights.data(), histogram);
    EXPECT_NEAR(histogram[bin], 2 * 5 * 5, 0.01) << "the border has no gradient, bin " << bin;
  }
}

INSTANTIATE_TEST_SUITE_P(SiftKernels, EverySet,
                         testing::ValuesIn(SupportedSiftKernels().begin(),
                                           SupportedSiftKernels().end()),
                         [](const auto& set) {
                           std::string name = set.param.name;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace waymark::mapping::internal
