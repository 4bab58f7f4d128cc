// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mapping/features/internal/descriptor_grid.h"
#include "mapping/features/internal/lanes.h"
#include "mapping/features/internal/orientation_lanes.h"
#include "mapping/features/internal/sift_kernels.h"

namespace waymark::mapping::internal::WAYMARK_LANES {

using Grid = DescriptorGrid;
constexpr int kCells = 4;  ///< in a row, and rows of them
constexpr int kBins = 8;   ///< directions of a cell

/// The image at the grid's places, by bilinear interpolation; beyond the border its last pixels.
inline void SampleGrid(const DescriptorWindow& window, const Grid& grid, float* samples) {
  const Plane& plane = window.plane;
  const float a = window.cell_width * window.cosine, b = window.cell_width * window.sine;
  const auto last_x = static_cast<float>(plane.width - 1);
  const auto last_y = static_cast<float>(plane.height - 1);
  const int stride = static_cast<int>(plane.stride);
  for (int i = 0; i < Grid::kPadded; i += kLanes) {
    const Floats u = Load(grid.u + i), v = Load(grid.v + i);
    const Floats x = Min(Max(window.x + (u * a - v * b), Set(0)), Set(last_x));
    const Floats y = Min(Max(window.y + (u * b + v * a), Set(0)), Set(last_y));
    const Ints column = ToInts(Min(x, Set(last_x - 1))), row = ToInts(Min(y, Set(last_y - 1)));
    const Floats fx = x - ToFloats(column), fy = y - ToFloats(row);
    const Ints index = row * stride + column;
    const Pairs above = GatherPairs(plane.data, index);
    const Pairs below = GatherPairs(plane.data + stride, index);
    const Floats top = above.first + fx * (above.second - above.first);
    const Floats bottom = below.first + fx * (below.second - below.first);
    Store(samples + i, top + fy * (bottom - top));
  }
}

/// The gradients of the grid: each goes to two neighbouring bins of direction.
struct Gradients {
  alignas(64) float first[Grid::kPaddedGradients];   ///< the share of bin `bins`
  alignas(64) float second[Grid::kPaddedGradients];  ///< the share of the bin behind it
  alignas(64) std::int32_t bins[Grid::kPaddedGradients];
};

inline void ComputeGradients(const Grid& grid, const float* samples, Gradients& gradients) {
  for (int i = 0; i < Grid::kPaddedGradients; i += kLanes) {
    const float* const middle = samples + Grid::kSide + i;
    const Floats du = Load(middle + 1) - Load(middle - 1);
    const Floats dv = Load(middle + Grid::kSide) - Load(middle - Grid::kSide);
    const Floats size = Sqrt(du * du + dv * dv) * Load(grid.weights + i);
    const Floats direction = Turns(du, -dv) * static_cast<float>(kBins);
    const Ints bin = ToInts(direction);
    const Floats second = size * (direction - ToFloats(bin));
    Store(gradients.first + i, size - second);
    Store(gradients.second + i, second);
    Store(gradients.bins + i, bin & (kBins - 1));
  }
}

/// Takes away what lies at the image's border or beyond it.
inline void ClipGradients(const DescriptorWindow& window, const Grid& grid, Gradients& gradients) {
  const float a = window.cell_width * window.cosine, b = window.cell_width * window.sine;
  const float reach = window.cell_width * 3.8F;  // to the grid's corner
  const auto end_x = static_cast<float>(window.plane.width - 2);
  const auto end_y = static_cast<float>(window.plane.height - 2);
  if (window.x - reach >= 1 && window.y - reach >= 1 && window.x + reach <= end_x &&
      window.y + reach <= end_y) {
    return;
  }
  for (int i = 0; i < Grid::kPaddedGradients; i += kLanes) {
    const Floats u = Load(grid.u + Grid::kSide + i), v = Load(grid.v + Grid::kSide + i);
    const Floats x = window.x + (u * a - v * b), y = window.y + (u * b + v * a);
    const Mask inside = And(And(GreaterEqual(x, Set(1)), GreaterEqual(Set(end_x), x)),
                            And(GreaterEqual(y, Set(1)), GreaterEqual(Set(end_y), y)));
    Store(gradients.first + i, Select(inside, Load(gradients.first + i), Set(0)));
    Store(gradients.second + i, Select(inside, Load(gradients.second + i), Set(0)));
  }
}

/// The grid's row as histograms of four cells. A gradient goes to the two cells whose middles it
/// lies between: to the one ahead by the share `rising`, to the one behind by the rest.
inline void AddRow(const Gradients& gradients, int row, Eight cells[kCells]) {
  alignas(64) static constexpr float kOneHot[2 * kBins] = {1, 0, 0, 0, 0, 0, 0, 0, 1};
  int i = row * Grid::kSide + 1;
#pragma GCC unroll 5
  for (int group = 0; group <= kCells; ++group) {
    Eight sum{}, rising{};
#pragma GCC unroll 4
    for (int q = 0; q < Grid::kPerCell; ++q, ++i) {
      const float* const one_hot = kOneHot + kBins - gradients.bins[i];
      const Eight shares = Eight::From(one_hot) * gradients.first[i] +
                           Eight::From(one_hot - 1) * gradients.second[i];
      sum = sum + shares;
      rising = rising + shares * ((static_cast<float>(q) + 0.5F) / Grid::kPerCell);
    }
    if (group < kCells) cells[group] = rising;
    if (group > 0) cells[group - 1] = cells[group - 1] + (sum - rising);
  }
}

inline void AddCells(const Gradients& gradients, Eight histogram[kCells][kCells]) {
  for (int row = 0; row < Grid::kGradientRows; ++row) {
    Eight cells[kCells];
    AddRow(gradients, row, cells);
    const int group = row / Grid::kPerCell;
    const float rising = (static_cast<float>(row % Grid::kPerCell) + 0.5F) / Grid::kPerCell;
    for (int c = 0; c < kCells; ++c) {
      if (group < kCells) histogram[group][c] = histogram[group][c] + cells[c] * rising;
      if (group > 0) {
        histogram[group - 1][c] = histogram[group - 1][c] + cells[c] * (1 - rising);
      }
    }
  }
}

inline float Sum(const Eight& value) {
  float lanes[8];
  value.To(lanes);
  return ((lanes[0] + lanes[4]) + (lanes[1] + lanes[5])) +
         ((lanes[2] + lanes[6]) + (lanes[3] + lanes[7]));
}

/// Lowe's limit of a fifth of the length, then RootSIFT in bytes.
inline void Quantise(float* histogram, std::uint8_t* descriptor) {
  Eight squares{};
  for (int i = 0; i < kDescriptorLength; i += 8) {
    Eight value = Eight::From(histogram + i);
    for (auto& part : value.parts) part *= part;
    squares = squares + value;
  }
  const Floats limit = Set(0.2F * __builtin_sqrtf(Sum(squares)));
  for (int i = 0; i < kDescriptorLength; i += kLanes) {
    Store(histogram + i, Min(Load(histogram + i), limit));
  }
  Eight total{};
  for (int i = 0; i < kDescriptorLength; i += 8) total = total + Eight::From(histogram + i);
  const float sum = Sum(total);
  const float scale = sum > 0 ? 512.0F / __builtin_sqrtf(sum) : 0.0F;
  for (int i = 0; i < kDescriptorLength; i += kLanes) {
    const Ints bytes = ToInts(Min(Sqrt(Load(histogram + i)) * scale + 0.5F, Set(255)));
    for (int lane = 0; lane < kLanes; ++lane) {
      descriptor[i + lane] = static_cast<std::uint8_t>(bytes[lane]);
    }
  }
}

inline void Describe(const DescriptorWindow& window, std::uint8_t* descriptor) {
  const Grid& grid = TheDescriptorGrid();
  // The last vector of gradients reads past the last row of samples.
  alignas(64) float samples[Grid::kPaddedGradients + 2 * Grid::kSide + 16] = {};
  SampleGrid(window, grid, samples);
  Gradients gradients;
  ComputeGradients(grid, samples, gradients);
  ClipGradients(window, grid, gradients);
  Eight cells[kCells][kCells] = {};
  AddCells(gradients, cells);
  alignas(64) float histogram[kDescriptorLength];
  for (int i = 0; i < kCells * kCells; ++i) cells[i / kCells][i % kCells].To(histogram + 8 * i);
  Quantise(histogram, descriptor);
}

}  // namespace waymark::mapping::internal::WAYMARK_LANES
