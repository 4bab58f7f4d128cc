// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/canvas.h"

#include <algorithm>
#include <cmath>

#include "mapping/base/check.h"

namespace waymark::simulator {
namespace {

std::uint8_t ToByte(float value) {
  return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
}

Texel ToTexel(const Paint& paint) {
  return {ToByte(paint.red), ToByte(paint.green), ToByte(paint.blue), ToByte(paint.emission)};
}

/// Pixels whose centres lie in [low, high), clipped to [0, size).
struct PixelRange {
  int begin;
  int end;
};

PixelRange Clip(double low, double high, int size) {
  const double limit = size;
  return {static_cast<int>(std::ceil(std::clamp(low - 0.5, 0.0, limit))),
          static_cast<int>(std::ceil(std::clamp(high - 0.5, 0.0, limit)))};
}

}  // namespace

Paint MutedPaint(Random& random, double darkest, double brightest) {
  const double level = random.Uniform(darkest, brightest);
  const double warmth = random.Uniform(-0.06, 0.22);
  const double green = random.Uniform(-0.06, 0.06);
  return {static_cast<float>(level * (1 + warmth)), static_cast<float>(level * (1 + green)),
          static_cast<float>(level * (1 - warmth)), 0};
}

Paint VividPaint(Random& random) {
  std::array<float, 3> channel{random.UniformFloat(150, 235), random.UniformFloat(20, 90),
                               random.UniformFloat(20, 200)};
  std::rotate(channel.begin(), channel.begin() + random.Integer(0, 2), channel.end());
  if (random.Chance(0.5)) std::swap(channel[0], channel[1]);
  const float grey = (channel[0] + channel[1] + channel[2]) / 3;
  const float fading = random.UniformFloat(0.15, 0.6);  // paint in the street is not new
  for (float& value : channel) value += fading * (grey - value);
  return {channel[0], channel[1], channel[2], 0};
}

Canvas::Canvas(int width_px, int height_px, const Paint& paint)
    : width_px_(width_px),
      height_px_(height_px),
      texels_(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px),
              ToTexel(paint)) {}

void Canvas::FillRectangle(double x0, double y0, double x1, double y1, const Paint& paint) {
  const PixelRange columns = Clip(x0, x1, width_px_);
  const PixelRange rows = Clip(y0, y1, height_px_);
  if (columns.begin >= columns.end) return;
  const Texel texel = ToTexel(paint);
  for (int y = rows.begin; y < rows.end; ++y) {
    const auto line = texels_.begin() + static_cast<std::ptrdiff_t>(y) * width_px_;
    std::fill(line + columns.begin, line + columns.end, texel);
  }
}

void Canvas::FillDisc(double x, double y, double radius, const Paint& paint) {
  const PixelRange rows = Clip(y - radius, y + radius, height_px_);
  for (int row = rows.begin; row < rows.end; ++row) {
    const double dy = row + 0.5 - y;
    const double half = std::sqrt(std::max(0.0, radius * radius - dy * dy));
    FillRectangle(x - half, row, x + half, row + 1, paint);
  }
}

void Canvas::DrawLine(double x0, double y0, double x1, double y1, double width,
                      const Paint& paint) {
  const double dx = x1 - x0;
  const double dy = y1 - y0;
  const double squared_length = std::max(dx * dx + dy * dy, 1e-9);
  const double half = width / 2;
  const PixelRange columns = Clip(std::min(x0, x1) - half, std::max(x0, x1) + half, width_px_);
  const PixelRange rows = Clip(std::min(y0, y1) - half, std::max(y0, y1) + half, height_px_);
  const Texel texel = ToTexel(paint);
  for (int row = rows.begin; row < rows.end; ++row) {
    for (int column = columns.begin; column < columns.end; ++column) {
      const double px = column + 0.5 - x0;
      const double py = row + 0.5 - y0;
      const double along = std::clamp((px * dx + py * dy) / squared_length, 0.0, 1.0);
      const double ex = px - along * dx;
      const double ey = py - along * dy;
      if (ex * ex + ey * ey > half * half) continue;
      texels_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_px_) +
              static_cast<std::size_t>(column)] = texel;
    }
  }
}

void Canvas::DrawWord(double x, double y, double height, int letters, Random& random,
                      const Paint& paint) {
  const double advance = height * 0.72;
  const double letter_width = height * 0.52;
  for (int i = 0; i < letters; ++i) {
    const double left = x + i * advance;
    const auto at = [&](int node) {  // nodes of a 3 x 3 grid, as on a seven-segment display
      return std::array{left + letter_width * (node % 3) / 2, y + height * (node / 3) / 2.0};
    };
    int node = random.Integer(0, 8);
    for (int stroke = 0; stroke < 4; ++stroke) {
      const int next = (node + random.Integer(1, 8)) % 9;
      const auto a = at(node);
      const auto b = at(next);
      DrawLine(a[0], a[1], b[0], b[1], height * 0.14, paint);
      node = next;
    }
  }
}

void Canvas::Weather(std::span<const float> relief) {
  CHECK(relief.size() == texels_.size(), "relief of {} for {} texels", relief.size(),
        texels_.size());
  for (std::size_t i = 0; i < texels_.size(); ++i) {
    const float gain = std::max(0.05F, 1 + relief[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      texels_[i][c] = ToByte(static_cast<float>(texels_[i][c]) * gain);
    }
  }
}

}  // namespace waymark::simulator
