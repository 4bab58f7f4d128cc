// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/texture.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace waymark::simulator {
namespace {

constexpr int kMaxTaps = 8;
/// This near to a level the other one is left out.
constexpr float kLevelSnap = 0.12F;
/// A trilinear sample is a little wider than a pixel; this much of a level gives the sharpness
/// back.
constexpr float kSharpness = -0.35F;

/// Four bytes as four 16-bit lanes, so that one multiplication weights all channels.
std::uint64_t Spread(const Texel& texel) {
  const std::uint64_t packed = std::bit_cast<std::uint32_t>(texel);
  const std::uint64_t halves = (packed | (packed << 16)) & 0x0000ffff0000ffffULL;
  return (halves | (halves << 8)) & 0x00ff00ff00ff00ffULL;
}

/// Lengths of the axes of the ellipse that a 2 x 2 matrix makes of a circle, and the long one's
/// direction.
struct Ellipse {
  float long_axis;
  float short_axis;
  Eigen::Vector2f long_direction;
};

Ellipse MakeEllipse(const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  const float xx = a.x() * a.x() + b.x() * b.x();
  const float yy = a.y() * a.y() + b.y() * b.y();
  const float xy = a.x() * a.y() + b.x() * b.y();
  const float mean = (xx + yy) / 2;
  const float half = (xx - yy) / 2;
  const float spread = std::sqrt(half * half + xy * xy);
  Eigen::Vector2f direction =
      half >= 0 ? Eigen::Vector2f(half + spread, xy) : Eigen::Vector2f(xy, spread - half);
  const float norm = direction.norm();
  direction = norm > 1e-20F ? Eigen::Vector2f(direction / norm) : Eigen::Vector2f(1, 0);
  return {std::sqrt(mean + spread), std::sqrt(std::max(0.0F, mean - spread)), direction};
}

/// Adds up bilinear samples (four lanes of 16 bits in 1/256 of a level) with weights of 1/256.
/// Two lanes of 32 bits each hold the sum of up to kMaxTaps samples without overflow.
class LaneSum {
 public:
  void Add(std::uint64_t lanes, std::uint64_t weight) {
    even_ += (lanes & kEven) * weight;
    odd_ += ((lanes >> 16) & kEven) * weight;
  }
  Colour Mean(int count) const {
    const float scale = 1 / (65536.0F * static_cast<float>(count));
    const auto lane = [scale](std::uint64_t sum) {
      return scale * static_cast<float>(static_cast<std::uint32_t>(sum));
    };
    return {lane(even_), lane(odd_), lane(even_ >> 32), lane(odd_ >> 32)};
  }

 private:
  static constexpr std::uint64_t kEven = 0x0000ffff0000ffffULL;

  std::uint64_t even_ = 0;
  std::uint64_t odd_ = 0;
};

}  // namespace

Texture::Texture(const Canvas& canvas, TextureBorder border) : border_(border) {
  levels_.push_back(
      {canvas.width_px(), canvas.height_px(), {canvas.texels().begin(), canvas.texels().end()}});
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse{std::max(1, fine.width / 2), std::max(1, fine.height / 2), {}};
    coarse.texels.reserve(static_cast<std::size_t>(coarse.width) *
                          static_cast<std::size_t>(coarse.height));
    for (int y = 0; y < coarse.height; ++y) {
      const auto row0 = static_cast<std::size_t>(2 * y) * static_cast<std::size_t>(fine.width);
      const auto row1 = static_cast<std::size_t>(std::min(2 * y + 1, fine.height - 1)) *
                        static_cast<std::size_t>(fine.width);
      for (int x = 0; x < coarse.width; ++x) {
        const auto x0 = static_cast<std::size_t>(2 * x);
        const auto x1 = static_cast<std::size_t>(std::min(2 * x + 1, fine.width - 1));
        Texel mean;
        for (std::size_t c = 0; c < 4; ++c) {
          const int sum = fine.texels[row0 + x0][c] + fine.texels[row0 + x1][c] +
                          fine.texels[row1 + x0][c] + fine.texels[row1 + x1][c];
          mean[c] = static_cast<std::uint8_t>((sum + 2) / 4);
        }
        coarse.texels.push_back(mean);
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

std::uint64_t Texture::Bilinear(const Level& level, const Eigen::Vector2f& place) const {
  const float x = place.x() * static_cast<float>(level.width) - 0.5F;
  const float y = place.y() * static_cast<float>(level.height) - 0.5F;
  int x0 = static_cast<int>(x + 1) - 1;  // floor, as x > -1
  int y0 = static_cast<int>(y + 1) - 1;
  const auto fx = static_cast<std::uint64_t>((x - static_cast<float>(x0)) * 256);
  const auto fy = static_cast<std::uint64_t>((y - static_cast<float>(y0)) * 256);
  int x1 = x0 + 1;
  int y1 = y0 + 1;
  if (border_ == TextureBorder::kClamp) {
    x0 = std::clamp(x0, 0, level.width - 1);
    x1 = std::clamp(x1, 0, level.width - 1);
    y0 = std::clamp(y0, 0, level.height - 1);
    y1 = std::clamp(y1, 0, level.height - 1);
  } else {  // `place` is in [0, 1), so indices leave the picture by one at most
    if (x0 < 0) x0 = level.width - 1;
    if (x1 >= level.width) x1 = 0;
    if (y0 < 0) y0 = level.height - 1;
    if (y1 >= level.height) y1 = 0;
  }
  const Texel* row0 = level.texels.data() + static_cast<std::ptrdiff_t>(y0) * level.width;
  const Texel* row1 = level.texels.data() + static_cast<std::ptrdiff_t>(y1) * level.width;
  // The four weights sum to 256, so that no 16-bit lane overflows into its neighbour.
  const std::uint64_t w11 = (fx * fy + 128) >> 8;
  const std::uint64_t w10 = fx - w11;
  const std::uint64_t w01 = fy - w11;
  const std::uint64_t w00 = 256 - fx - fy + w11;
  return Spread(row0[x0]) * w00 + Spread(row0[x1]) * w10 + Spread(row1[x0]) * w01 +
         Spread(row1[x1]) * w11;
}

Colour Texture::Sample(const Footprint& footprint) const {
  const Eigen::Vector2f size(static_cast<float>(levels_[0].width),
                             static_cast<float>(levels_[0].height));
  const Ellipse ellipse =
      MakeEllipse(footprint.step_right.cwiseProduct(size), footprint.step_down.cwiseProduct(size));
  const float flatness = ellipse.long_axis / std::max(ellipse.short_axis, 1e-3F);
  const int taps = std::clamp(static_cast<int>(flatness + 0.4F), 1, kMaxTaps);
  const float width = std::max(ellipse.short_axis, ellipse.long_axis / static_cast<float>(taps));
  const float depth = std::clamp(std::log2(std::max(width, 1e-6F)) + kSharpness, 0.0F,
                                 static_cast<float>(levels_.size() - 1));
  const auto fine = static_cast<std::size_t>(depth + kLevelSnap);
  const std::size_t coarse = std::min(fine + 1, levels_.size() - 1);
  const float remainder = depth - static_cast<float>(fine);
  const std::uint64_t coarse_weight =
      remainder < kLevelSnap ? 0 : static_cast<std::uint64_t>(remainder * 256);
  const Eigen::Vector2f stride =
      (ellipse.long_axis / static_cast<float>(taps)) * ellipse.long_direction.cwiseQuotient(size);
  LaneSum sum;
  for (int i = 0; i < taps; ++i) {
    Eigen::Vector2f place =
        footprint.centre + (static_cast<float>(i) - static_cast<float>(taps - 1) / 2) * stride;
    if (border_ == TextureBorder::kRepeat) {
      place -= place.array().floor().matrix();
    } else {
      place = place.cwiseMax(0).cwiseMin(1);
    }
    sum.Add(Bilinear(levels_[fine], place), 256 - coarse_weight);
    if (coarse_weight > 0) sum.Add(Bilinear(levels_[coarse], place), coarse_weight);
  }
  return sum.Mean(taps);
}

}  // namespace waymark::simulator
