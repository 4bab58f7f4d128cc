// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "examples/simulator/render/denoise.h"

namespace waymark::simulator {
namespace {

constexpr float kVisibleNoise = 5;  // levels; cameras leave less as it is

/// Normal deviates to draw from by index: a Box-Muller per channel would cost as much as shading.
const std::array<float, 65536>& NormalTable() {
  static const auto table = [] {
    std::array<float, 65536> values{};
    Random random(0x6e6f697365ULL);
    for (float& value : values) value = static_cast<float>(random.Normal(1));
    return values;
  }();
  return table;
}

}  // namespace

ColourImage Expose(const Radiance& radiance, const Lighting& lighting, const SensorOptions& options,
                   Random random) {
  const double sum = std::accumulate(radiance.values.begin(), radiance.values.end(), 0.0);
  const auto mean = static_cast<float>(
      sum / static_cast<double>(std::max<std::size_t>(1, radiance.values.size())));
  const float automatic =
      std::clamp(options.target_mean / std::max(mean, 1.0F), 0.4F, lighting.longest_gain);
  const float gain = automatic * std::exp2(options.bias_ev / 2.2F);  // values carry gamma 2.2
  const float read_noise = options.noise_scale * lighting.noise * std::max(1.0F, gain);
  const auto& normals = NormalTable();
  ColourImage image{radiance.width_px, radiance.height_px, {}};
  image.values.reserve(radiance.values.size());
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < radiance.values.size(); ++i) {
    bits = i % 4 == 0 ? random.Bits() : bits >> 16;
    const float value = gain * radiance.values[i];
    const float sigma = read_noise * (0.7F + 0.3F * value / 128);
    const float noisy = value + sigma * normals[bits & 0xffff];
    image.values.push_back(static_cast<std::uint8_t>(std::clamp(noisy + 0.5F, 0.0F, 255.0F)));
  }
  return read_noise > kVisibleNoise ? Denoise(image, read_noise) : image;
}

}  // namespace waymark::simulator
