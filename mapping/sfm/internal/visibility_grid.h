// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace waymark::mapping::internal {

/// How many known points an image would see, and how well they are spread over it: many points in
/// one corner determine a pose worse than fewer all over.
/// Source: Schoenberger & Frahm, CVPR 2016, section 4.2.
class VisibilityGrid {
 public:
  VisibilityGrid(int width_px, int height_px) : width_px_(width_px), height_px_(height_px) {}

  void Add(double x_px, double y_px) { Change(x_px, y_px, 1); }
  void Remove(double x_px, double y_px) { Change(x_px, y_px, -1); }

  int count() const { return count_; }
  /// Occupied cells of a 2x2, a 4x4 and an 8x8 grid; finer cells count more.
  int score() const { return score_; }

 private:
  static constexpr std::array<int, 3> kSides{2, 4, 8};

  void Change(double x_px, double y_px, int change);

  int width_px_;
  int height_px_;
  int count_ = 0;
  int score_ = 0;
  std::array<int, 4 + 16 + 64> cells_{};
};

}  // namespace waymark::mapping::internal
