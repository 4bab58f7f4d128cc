// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

// No Eigen here: the loops are compiled for wider registers, which change its alignment.
namespace waymark::mapping::internal {

/// Unknowns of a pose, or of a camera's intrinsics, at most.
inline constexpr std::size_t kBlockSize = 6;
/// Columns of a block are padded with zeros to this length.
inline constexpr std::size_t kColumn = 8;
inline constexpr std::size_t kBlockDoubles = kBlockSize * kColumn;

/// One observation, linearised and weighted by its loss: row u, then row v. A pose's translation
/// moves the residual as the point does, with the other sign.
struct ObservationTerms {
  double residual[2];
  double by_point[2][3];
  double by_rotation[2][3];
  double by_camera[2][kBlockSize];  ///< free intrinsics; the rest is zero
};

/// Which blocks an observation moves; -1: what it moves is held.
struct ObservationBlocks {
  std::int32_t pose = -1;
  std::int32_t camera = -1;
};

/// Where the product of two blocks is summed up: `slots[a * block_count + b]` for a <= b. Poses
/// come before cameras.
struct BlockPattern {
  std::size_t block_count = 0;
  std::size_t slot_count = 0;
  std::vector<std::int32_t> slots = {};  ///< -1: the product is always zero

  std::size_t Slot(std::size_t a, std::size_t b) const {
    return static_cast<std::size_t>(slots[a * block_count + b]);
  }
};

/// Sums over points: the reduced normal equations, upper blocks only.
struct BlockSums {
  std::vector<double> blocks;     ///< by slot, kBlockDoubles each, columns of length kColumn
  std::vector<double> right;      ///< by block, kColumn each
  std::vector<double> diagonals;  ///< by block: of the equations before points were eliminated

  void Reset(const BlockPattern& pattern);
  void Add(const BlockSums& other);
};

/// Observations of one point, ordered by pose block, and scratch of the elimination.
struct PointObservations {
  std::span<const ObservationTerms> terms;
  std::span<const ObservationBlocks> blocks;
};

/// Adds one point's observations to the sums with the point eliminated. Damping multiplies the
/// diagonal of its own equations. The same to the last bit on every processor.
/// Source: Triggs et al., "Bundle adjustment - a modern synthesis", 1999, section 6.1.
class PointEliminator {
 public:
  explicit PointEliminator(const BlockPattern& pattern) : pattern_(pattern) {}

  void Eliminate(const PointObservations& point, double damping, BlockSums& sums);

 private:
  const BlockPattern& pattern_;
  std::vector<double> products_;  // of each block that moves the point: 3 columns
  std::vector<double> solved_;
  std::vector<std::int32_t> moved_;
};

/// The point's step that belongs to the steps of the blocks (kColumn each).
/// Returns by how much the linearised cost decreases through this point's observations.
double SolvePoint(const PointObservations& point, double damping, std::span<const double> steps,
                  double (&step)[3]);

}  // namespace waymark::mapping::internal
