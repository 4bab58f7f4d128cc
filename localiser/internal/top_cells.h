// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace waymark::localiser::internal {

/// Chooses the cells of the largest dot products. The best of each of many strides through the
/// cells are as many different cells, so the last wanted of those bounds the last wanted of all
/// from below, and few cells are left to sort.
class TopCells {
 public:
  /// Shapes: 1 <= wanted <= cells.
  TopCells(std::size_t cells, std::size_t wanted);

  /// Most similar first; ties go to the lower cell. Shapes: one dot per cell.
  void AppendTo(std::span<const std::int32_t> dots, std::vector<std::uint32_t>& cells);

 private:
  std::size_t wanted_;
  bool is_bounded_;
  std::vector<std::uint32_t> candidates_;
  std::vector<std::int64_t> order_;
};

}  // namespace waymark::localiser::internal
