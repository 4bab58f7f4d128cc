// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/internal/descriptor_grid.h"

#include <cmath>

namespace waymark::mapping::internal {
namespace {

DescriptorGrid MakeGrid() {
  using Grid = DescriptorGrid;
  Grid grid{};
  for (int i = 0; i < Grid::kSamples; ++i) {
    const auto from_middle = [](int step) {
      return (static_cast<float>(step) - (Grid::kSide - 1) / 2.0F) / Grid::kPerCell;
    };
    grid.u[i] = from_middle(i % Grid::kSide);
    grid.v[i] = from_middle(i / Grid::kSide);
  }
  for (int i = 0; i < Grid::kGradients; ++i) {
    const int column = i % Grid::kSide;
    if (column == 0 || column == Grid::kSide - 1) continue;
    const float u = grid.u[i + Grid::kSide], v = grid.v[i + Grid::kSide];
    grid.weights[i] = std::exp(-(u * u + v * v) / 8);  // sigma: half the width of four cells
  }
  return grid;
}

}  // namespace

const DescriptorGrid& TheDescriptorGrid() {
  static const DescriptorGrid grid = MakeGrid();
  return grid;
}

}  // namespace waymark::mapping::internal
