// SPDX-License-Identifier: Apache-2.0
#include "session/state/pose_grid.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace waymark::session {
namespace {

constexpr double kFinest_m = 4;
constexpr int kCoarsestLevel = 4;          // 64 m
constexpr std::int64_t kMiddle = 1 << 24;  // cells from the map's origin that exist

std::int64_t CellAlong(double coordinate_m, int level) {
  const auto cell = static_cast<std::int64_t>(std::floor(coordinate_m / kFinest_m));
  return std::clamp(cell + kMiddle, std::int64_t{0}, 2 * kMiddle - 1) >> level;
}

/// The bits of a number apart by one.
std::uint64_t Spread(std::int64_t number) {
  auto bits = static_cast<std::uint64_t>(number) & 0xffffffff;
  bits = (bits | bits << 16) & 0x0000ffff0000ffff;
  bits = (bits | bits << 8) & 0x00ff00ff00ff00ff;
  bits = (bits | bits << 4) & 0x0f0f0f0f0f0f0f0f;
  bits = (bits | bits << 2) & 0x3333333333333333;
  return (bits | bits << 1) & 0x5555555555555555;
}

std::uint64_t CellNumber(std::int64_t x, std::int64_t y) { return Spread(x) | Spread(y) << 1; }

}  // namespace

void PoseGrid::Add(std::uint32_t slot, const Eigen::Vector3d& position_m) {
  standing_.push_back(
      {CellNumber(CellAlong(position_m.x(), 0), CellAlong(position_m.y(), 0)), slot});
}

void PoseGrid::Sort() {
  std::sort(standing_.begin(), standing_.end(), [](const Standing& a, const Standing& b) {
    return std::tie(a.cell, a.slot) < std::tie(b.cell, b.slot);
  });
}

PoseGrid::Neighbourhood PoseGrid::AtLevel(const Eigen::Vector3d& position_m, int level) const {
  Neighbourhood found;
  const std::int64_t x = CellAlong(position_m.x(), level), y = CellAlong(position_m.y(), level);
  const auto first_of = [&](std::uint64_t cell) {
    return std::lower_bound(
        standing_.begin(), standing_.end(), cell << 2 * level,
        [](const Standing& one, std::uint64_t wanted) { return one.cell < wanted; });
  };
  std::size_t run = 0;
  for (std::int64_t dy = -1; dy <= 1; ++dy) {
    for (std::int64_t dx = -1; dx <= 1; ++dx, ++run) {
      if (x + dx < 0 || y + dy < 0) continue;
      const std::uint64_t cell = CellNumber(x + dx, y + dy);
      found.runs[run] = {first_of(cell), first_of(cell + 1)};
      found.count += found.runs[run].size();
    }
  }
  return found;
}

PoseGrid::Neighbourhood PoseGrid::Near(const Eigen::Vector3d& position_m,
                                       std::size_t max_count) const {
  for (int level = kCoarsestLevel; level > 0; --level) {
    Neighbourhood found = AtLevel(position_m, level);
    if (found.count <= max_count) return found;
  }
  return AtLevel(position_m, 0);
}

}  // namespace waymark::session
