// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mapping/estimation/bundle_adjustment.h"
#include "mapping/estimation/internal/point_elimination.h"

namespace waymark::mapping::internal {

/// A problem in the order in which it is worked on: observations by point, unknowns in blocks,
/// poses first. Immutable.
struct BundleLayout {
  explicit BundleLayout(const BundleProblem& bundle);

  struct Observation {
    std::uint32_t pose;
    std::uint32_t camera;
    Eigen::Vector2d pixel_px;
  };

  std::vector<std::size_t> point_begins;  ///< of each point in `observations`, and one end
  std::vector<Observation> observations;  ///< by point, then by pose
  std::vector<ObservationBlocks> blocks;  ///< of observations
  std::vector<bool> pose_is_used;
  std::vector<std::int32_t> pose_blocks, camera_blocks;  ///< -1: held, or not used
  std::vector<std::vector<int>> free_parameters;         ///< of cameras
  std::vector<int> block_sizes;
  BlockPattern pattern;
  /// Points are worked on in parts, which depend on the problem alone: their sums are added in
  /// order, so any number of threads gives the same bits. Where they begin, and one end.
  std::vector<std::size_t> part_begins;

  std::size_t part_count() const { return part_begins.size() - 1; }

 private:
  void OrderObservations(const BundleProblem& bundle);
  void NumberBlocks(const BundleProblem& bundle);
  void FindPattern(const BundleProblem& bundle);
  void CutIntoParts();
};

}  // namespace waymark::mapping::internal
