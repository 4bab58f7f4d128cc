// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/noise.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "examples/simulator/random.h"

namespace waymark::simulator {
namespace {

/// Where a pixel lies on the lattice: its first of four nodes and their weights.
struct Tap {
  int node;
  std::array<float, 4> weight;
};

Tap MakeTap(float position) {
  const float floor = std::floor(position);
  const float t = position - floor;
  const float s = 1 - t;
  return {static_cast<int>(floor),
          {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6,
           t * t * t / 6}};
}

std::vector<Tap> MakeTaps(int count, float cell_px) {
  std::vector<Tap> taps;
  taps.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) taps.push_back(MakeTap(static_cast<float>(i) / cell_px));
  return taps;
}

/// White noise of unit variance, uniform: cheap, and the interpolation makes it bell-shaped.
std::vector<float> MakeLattice(int width, int height, std::uint64_t seed) {
  Random random(seed);
  std::vector<float> lattice(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (float& value : lattice) value = random.UniformFloat(-std::sqrt(3.0), std::sqrt(3.0));
  return lattice;
}

void AddOctave(std::vector<float>& field, int width_px, int height_px, const NoiseOctave& octave,
               std::uint64_t seed) {
  const std::vector<Tap> columns = MakeTaps(width_px, octave.cell_px);
  const std::vector<Tap> rows = MakeTaps(height_px, octave.cell_px);
  const int lattice_width = columns.back().node + 4;
  const std::vector<float> lattice = MakeLattice(lattice_width, rows.back().node + 4, seed);
  // Averaged over positions the spline keeps (151/315)^2 of the variance.
  const float gain = octave.amplitude * 315.0F / 151.0F;
  std::vector<float> blended(static_cast<std::size_t>(lattice_width));
  for (int y = 0; y < height_px; ++y) {
    const Tap& row = rows[static_cast<std::size_t>(y)];
    const float* nodes = lattice.data() + static_cast<std::ptrdiff_t>(row.node) * lattice_width;
    for (int x = 0; x < lattice_width; ++x) {
      blended[static_cast<std::size_t>(x)] =
          gain * (row.weight[0] * nodes[x] + row.weight[1] * nodes[x + lattice_width] +
                  row.weight[2] * nodes[x + 2 * lattice_width] +
                  row.weight[3] * nodes[x + 3 * lattice_width]);
    }
    float* out = field.data() + static_cast<std::ptrdiff_t>(y) * width_px;
    for (int x = 0; x < width_px; ++x) {
      const Tap& tap = columns[static_cast<std::size_t>(x)];
      const float* node = blended.data() + tap.node;
      out[x] += tap.weight[0] * node[0] + tap.weight[1] * node[1] + tap.weight[2] * node[2] +
                tap.weight[3] * node[3];
    }
  }
}

}  // namespace

std::vector<float> MakeNoise(int width_px, int height_px, const std::vector<NoiseOctave>& octaves,
                             std::uint64_t seed) {
  std::vector<float> field(static_cast<std::size_t>(width_px) *
                           static_cast<std::size_t>(height_px));
  Random random(seed);
  for (const NoiseOctave& octave : octaves) {
    AddOctave(field, width_px, height_px, octave, random.Bits());
  }
  return field;
}

}  // namespace waymark::simulator
