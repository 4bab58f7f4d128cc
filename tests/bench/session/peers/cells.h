// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <compare>
#include <vector>

namespace waymark::bench {

/// A square of the map, 50 m wide, as apps cut a city into topics.
struct Cell {
  int x = 0, y = 0;

  static constexpr double kEdge_m = 50;

  static Cell At(double x_m, double y_m) {
    return {static_cast<int>(std::floor(x_m / kEdge_m)),
            static_cast<int>(std::floor(y_m / kEdge_m))};
  }
  /// Differs from cell to cell within 25 km of the origin.
  int topic() const { return (x + 512) * 1024 + y + 512; }
  /// Itself and those that touch it.
  std::vector<Cell> Around() const {
    std::vector<Cell> around;
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) around.push_back({x + dx, y + dy});
    }
    return around;
  }

  friend auto operator<=>(const Cell&, const Cell&) = default;
};

}  // namespace waymark::bench
