// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/sift.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <tuple>

#include "mapping/features/internal/orientation.h"

namespace waymark::mapping::internal {
namespace {

constexpr float kCellSigmas = 3;  ///< side of a descriptor's cell, in the extremum's sigmas

/// Pixels of the image to a pixel of the octave; octave 0 is the doubled image.
float PixelSize(const Extremum& extremum) { return std::ldexp(0.5F, extremum.octave); }

Keypoint KeypointOf(const Extremum& extremum, float angle_rad) {
  const float size = PixelSize(extremum);
  // Octave pixel 0 is pixel 0 of the doubled image in every octave.
  return {.x_px = extremum.x * size + 0.25F,
          .y_px = extremum.y * size + 0.25F,
          .scale_px = 2 * extremum.sigma * size,
          .angle_rad = angle_rad};
}

struct Rank {
  float strength;
  float y_px;
  float x_px;
  float scale_px;
  std::uint32_t extremum;

  bool operator<(const Rank& other) const {
    return std::tie(other.strength, y_px, x_px, scale_px) <
           std::tie(strength, other.y_px, other.x_px, other.scale_px);
  }
};

/// Indices of the extrema, the strongest first, ties by place. Several pixels may have led to one
/// extremum: it is named once.
std::vector<std::uint32_t> OrderByStrength(const std::vector<Extremum>& extrema) {
  std::vector<Rank> ranks;
  ranks.reserve(extrema.size());
  for (const Extremum& extremum : extrema) {
    const Keypoint place = KeypointOf(extremum, 0);
    ranks.push_back({extremum.strength, place.y_px, place.x_px, place.scale_px,
                     static_cast<std::uint32_t>(ranks.size())});
  }
  std::sort(ranks.begin(), ranks.end());
  std::vector<std::uint32_t> order;
  order.reserve(ranks.size());
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    if (i == 0 || ranks[i - 1] < ranks[i]) order.push_back(ranks[i].extremum);
  }
  return order;
}

const Plane& LayerOf(const ScaleSpace& space, const Extremum& extremum) {
  return space.octaves[extremum.octave][extremum.layer - 1];
}

/// Brings the square around an extremum into the cache: to be called one extremum early.
void Prefetch(const ScaleSpace& space, const Extremum& extremum, float reach_sigmas) {
  constexpr int kLine = 16;  ///< floats
  const Plane& plane = LayerOf(space, extremum);
  const int reach = static_cast<int>(reach_sigmas * extremum.sigma) + 1;
  const int left = std::max(extremum.column - reach, 0);
  const int right = std::min(extremum.column + reach, plane.width - 1);
  const int bottom = std::min(extremum.row + reach, plane.height - 1);
  for (int y = std::max(extremum.row - reach, 0); y <= bottom; ++y) {
    const float* const row = plane.data + y * plane.stride;
    for (int x = left / kLine * kLine; x <= right; x += kLine) __builtin_prefetch(row + x);
  }
}

/// `extrema` with their orientations, in order. They are visited in the order of the scale space's
/// rows: neighbours share what is in the cache.
void AppendOriented(const ScaleSpace& space, std::span<const std::uint32_t> extrema,
                    const SiftKernels& kernels, std::vector<OrientedExtremum>& oriented) {
  struct Visit {
    std::uint32_t extremum;
    std::uint32_t rank;
    float angle_rad;
  };
  std::vector<Visit> visits, found;
  for (const std::uint32_t extremum : extrema) {
    visits.push_back({extremum, static_cast<std::uint32_t>(visits.size()), 0});
  }
  std::sort(visits.begin(), visits.end(),
            [](const Visit& a, const Visit& b) { return a.extremum < b.extremum; });
  OrientationRoom room;
  for (std::size_t i = 0; i < visits.size(); ++i) {
    if (i + 1 < visits.size()) Prefetch(space, space.extrema[visits[i + 1].extremum], 4.5F);
    Visit visit = visits[i];
    const Extremum& extremum = space.extrema[visit.extremum];
    for (const float angle_rad :
         FindOrientations_rad(LayerOf(space, extremum), extremum, kernels, room)) {
      visit.angle_rad = angle_rad;
      found.push_back(visit);
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Visit& a, const Visit& b) { return a.rank < b.rank; });
  for (const Visit& visit : found) oriented.push_back({visit.extremum, visit.angle_rad});
}

}  // namespace

std::vector<OrientedExtremum> SelectStrongest(const ScaleSpace& space, int max_features,
                                              const SiftKernels& kernels) {
  const std::vector<std::uint32_t> order = OrderByStrength(space.extrema);
  const auto limit = static_cast<std::size_t>(max_features);
  std::vector<OrientedExtremum> selected;
  for (std::size_t begin = 0; begin < order.size() && selected.size() < limit;) {
    const std::size_t count = std::min(limit - selected.size(), order.size() - begin);
    AppendOriented(space, std::span(order).subspan(begin, count), kernels, selected);
    begin += count;
  }
  if (selected.size() > limit) selected.resize(limit);
  return selected;
}

ImageFeatures DescribeAll(const ScaleSpace& space, const std::vector<OrientedExtremum>& selected,
                          const SiftKernels& kernels) {
  ImageFeatures features;
  features.keypoints.resize(selected.size());
  features.descriptors.resize(selected.size());
  // In the order of the scale space's rows: neighbours share what is in the cache.
  std::vector<std::size_t> order(selected.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tuple(selected[a].extremum, a) < std::tuple(selected[b].extremum, b);
  });
  for (std::size_t place = 0; place < order.size(); ++place) {
    const std::size_t i = order[place];
    if (place + 1 < order.size()) {
      Prefetch(space, space.extrema[selected[order[place + 1]].extremum], 8);
    }
    const auto& [index, angle_rad] = selected[i];
    const Extremum& extremum = space.extrema[index];
    features.keypoints[i] = KeypointOf(extremum, angle_rad);
    kernels.describe({.plane = LayerOf(space, extremum),
                      .x = extremum.x,
                      .y = extremum.y,
                      .cosine = std::cos(angle_rad),
                      .sine = std::sin(angle_rad),
                      .cell_width = kCellSigmas * extremum.sigma},
                     features.descriptors[i].data());
  }
  return features;
}

Result<ImageFeatures> ExtractSift(const ImageView& image, const ScaleSpaceOptions& options,
                                  int max_features, const SiftKernels& kernels) {
  WAYMARK_TRY_ASSIGN(const ScaleSpace space, BuildScaleSpace(image, options, kernels));
  return DescribeAll(space, SelectStrongest(space, max_features, kernels), kernels);
}

}  // namespace waymark::mapping::internal
