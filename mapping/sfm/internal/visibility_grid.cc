// SPDX-License-Identifier: Apache-2.0
#include "mapping/sfm/internal/visibility_grid.h"

#include <algorithm>
#include <cstddef>

namespace waymark::mapping::internal {

void VisibilityGrid::Change(double x_px, double y_px, int change) {
  count_ += change;
  std::size_t offset = 0;
  for (const int side : kSides) {
    const auto cell = [side](double at_px, int size_px) {
      return std::clamp(static_cast<int>(at_px / size_px * side), 0, side - 1);
    };
    const int column = cell(x_px, width_px_);
    const int row = cell(y_px, height_px_);
    int& points = cells_[offset + static_cast<std::size_t>(row * side + column)];
    const bool was_empty = points == 0;
    points += change;
    if (was_empty != (points == 0)) score_ += was_empty ? side * side : -side * side;
    offset += static_cast<std::size_t>(side * side);
  }
}

}  // namespace waymark::mapping::internal
