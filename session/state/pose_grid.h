// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace waymark::session {

/// Who stands near whom, on the ground. Cells of 4 m are ordered along a Z-curve, so that cells of
/// 8, 16, 32 and 64 m are runs of the same order. Thread-compatible.
class PoseGrid {
 public:
  struct Standing {
    std::uint64_t cell;
    std::uint32_t slot;  ///< whose it is, for the caller
  };
  /// Those in three by three cells, as runs. Who is within a cell's edge of the place is among
  /// them.
  struct Neighbourhood {
    std::array<std::span<const Standing>, 9> runs;
    std::size_t count = 0;
  };

  void Clear() { standing_.clear(); }
  void Add(std::uint32_t slot, const Eigen::Vector3d& position_m);
  /// Call it after the last Add.
  void Sort();

  /// The widest neighbourhood with at most `max_count` in it; the narrowest if all hold more.
  Neighbourhood Near(const Eigen::Vector3d& position_m, std::size_t max_count) const;

 private:
  Neighbourhood AtLevel(const Eigen::Vector3d& position_m, int level) const;

  std::vector<Standing> standing_;  // by cell, then slot
};

}  // namespace waymark::session
