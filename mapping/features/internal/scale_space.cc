// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/scale_space.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mapping/features/internal/octave_builder.h"

namespace waymark::mapping::internal {
namespace {

/// Lowe takes images for smooth by half a pixel. Bilinear doubling, which our Gaussian stands in
/// for, smooths by the variance of its weights 3/4 and 1/4.
double SigmaOfDoubling(double smoothing_px) {
  constexpr double kCamera_px = 0.5, kBilinearVariance_px2 = 3.0 / 16;
  const double first_px = SigmaOfLayer(0) / 2;
  return std::sqrt(smoothing_px * smoothing_px + first_px * first_px - kCamera_px * kCamera_px +
                   kBilinearVariance_px2);
}

/// Sizes of the octaves that have room for an extremum.
std::vector<std::pair<int, int>> ListSizes(int width, int height) {
  std::vector<std::pair<int, int>> sizes;
  for (; std::min(width, height) > 2 * kBorder_px; width /= 2, height /= 2) {
    sizes.emplace_back(width, height);
  }
  return sizes;
}

/// Lays the layers out in `memory` from its beginning.
std::vector<std::array<Plane, kLayers>> PlaceLayers(const std::vector<std::pair<int, int>>& sizes,
                                                    const float* memory) {
  std::vector<std::array<Plane, kLayers>> octaves;
  for (const auto& [width, height] : sizes) {
    std::array<Plane, kLayers>& layers = octaves.emplace_back();
    for (Plane& plane : layers) {
      plane = {memory, RowStride(width), width, height};
      memory += plane.stride * height;
    }
  }
  return octaves;
}

std::size_t LayersSize(const std::vector<std::pair<int, int>>& sizes) {
  std::size_t floats = 0;
  for (const auto& [width, height] : sizes) {
    floats += static_cast<std::size_t>(kLayers * RowStride(width) * height);
  }
  return floats;
}

/// Every other pixel of a row of the octave before.
void HalveRow(const Plane& before, int y, int width, float* out) {
  const float* const in = before.data + 2 * y * before.stride;
  for (int x = 0; x < width; ++x) out[x] = in[2 * x];
}

}  // namespace

Result<ScaleSpace> BuildScaleSpace(const ImageView& image, const ScaleSpaceOptions& options,
                                   const SiftKernels& kernels) {
  DoubledImage doubled(image, SigmaOfDoubling(options.smoothing_px), kernels);
  OctaveBuilder builder(options.extrema, kernels);
  const auto sizes = ListSizes(doubled.width(), doubled.height());
  if (sizes.empty()) return ScaleSpace{};
  const std::size_t layers_size = LayersSize(sizes),
                    builder_size = builder.WorkingSize(doubled.width());
  WAYMARK_TRY_ASSIGN(
      KeptBuffer memory,
      KeptBuffer::Take((layers_size + builder_size + doubled.WorkingSize()) * sizeof(float)));
  float* const floats = static_cast<float*>(memory.data());
  doubled.Start(floats + layers_size + builder_size);
  ScaleSpace space{
      .memory = std::move(memory), .octaves = PlaceLayers(sizes, floats), .extrema = {}};
  for (std::size_t o = 0; o < sizes.size(); ++o) {
    const auto make_row = [&](int y, float* out) {
      if (o == 0) {
        doubled.MakeRow(y, out);
      } else {
        HalveRow(space.octaves[o - 1].back(), y, sizes[o].first, out);
      }
    };
    builder.Build(static_cast<int>(o), make_row, space.octaves[o], floats + layers_size,
                  space.extrema);
  }
  return space;
}

}  // namespace waymark::mapping::internal
