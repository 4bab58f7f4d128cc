// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/localisation/picture_damage.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace waymark::evaluation {
namespace {

using mapping::GrayImage;

/// Weights around the middle, of an odd number of pixels; repeats the picture's edge.
GrayImage Convolve(const GrayImage& image, const std::vector<double>& weights, bool is_vertical) {
  GrayImage result = image;
  const int reach = static_cast<int>(weights.size() / 2);
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      double sum = 0;
      for (int k = -reach; k <= reach; ++k) {
        const int column = is_vertical ? x : std::clamp(x + k, 0, image.width_px - 1);
        const int row = is_vertical ? std::clamp(y + k, 0, image.height_px - 1) : y;
        sum += weights[static_cast<std::size_t>(k + reach)] *
               image.pixels[static_cast<std::size_t>(row * image.width_px + column)];
      }
      result.pixels[static_cast<std::size_t>(y * image.width_px + x)] =
          static_cast<std::uint8_t>(std::clamp(sum + 0.5, 0.0, 255.0));
    }
  }
  return result;
}

}  // namespace

GrayImage BlurOutOfFocus(const GrayImage& image, double sigma_px) {
  const int reach = static_cast<int>(std::ceil(3 * sigma_px));
  std::vector<double> weights;
  double sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    weights.push_back(std::exp(-0.5 * k * k / (sigma_px * sigma_px)));
    sum += weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return Convolve(Convolve(image, weights, false), weights, true);
}

GrayImage BlurByMotion(const GrayImage& image, int length_px) {
  const int odd = length_px / 2 * 2 + 1;
  return Convolve(image, std::vector<double>(static_cast<std::size_t>(odd), 1.0 / odd), false);
}

GrayImage Cover(const GrayImage& image, double share, simulator::Random random) {
  GrayImage covered = image;
  const int side = random.Integer(0, 3);
  const double bulge = random.Uniform(0, 0.15);
  const double level = random.Uniform(10, 60);
  constexpr double kEdge = 0.03;  // of the picture; fingers are out of focus
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      const double u = (x + 0.5) / image.width_px;
      const double v = (y + 0.5) / image.height_px;
      const double inwards = side == 0 ? u : side == 1 ? 1 - u : side == 2 ? v : 1 - v;
      const double across = side < 2 ? v : u;
      const double limit = share + bulge * (0.5 - 4 * (across - 0.5) * (across - 0.5));
      const double opacity = share >= 1 ? 1 : std::clamp((limit - inwards) / kEdge, 0.0, 1.0);
      auto& pixel = covered.pixels[static_cast<std::size_t>(y * image.width_px + x)];
      const double seen = pixel + opacity * (level + random.Normal(4) - pixel);
      pixel = static_cast<std::uint8_t>(std::clamp(seen, 0.0, 255.0));
    }
  }
  return covered;
}

GrayImage Mirror(const GrayImage& image) {
  GrayImage mirrored = image;
  for (int y = 0; y < image.height_px; ++y) {
    const auto row = mirrored.pixels.begin() + static_cast<std::ptrdiff_t>(y) * image.width_px;
    std::reverse(row, row + image.width_px);
  }
  return mirrored;
}

}  // namespace waymark::evaluation
