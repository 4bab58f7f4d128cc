// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "mapping/fusion/internal/block_kernels.h"
#include "mapping/fusion/internal/elimination_order.h"
#include "mapping/fusion/internal/large_pages.h"

namespace waymark::mapping {

/// Seven numbers move a submap: translation, rotation, logarithm of the scale.
using Block = Eigen::Matrix<double, 7, 7>;
using BlockVector = Eigen::Matrix<double, 7, 1>;

/// A symmetric matrix of 7x7 blocks. `off_diagonal[k]` has the rows of edge k's first unknown and
/// the columns of its second.
struct BlockMatrix {
  LargeVector<Block> diagonal;
  LargeVector<Block> off_diagonal;
};

/// Factorises symmetric positive definite matrices of one sparsity pattern: L L^T, right-looking.
/// Thread-compatible; the order of all operations is fixed by the pattern.
/// Source: Davis, "Direct Methods for Sparse Linear Systems", SIAM 2006, chapters 4 and 7.
class BlockCholesky {
 public:
  /// Shapes: `order` holds each unknown once; edges are distinct pairs of distinct unknowns.
  BlockCholesky(std::vector<std::uint32_t> order, std::span<const BlockEdge> edges);

  /// Factorises the matrix with `(1 + relative) * d + absolute` for every element d of its
  /// diagonal. False when the outcome is not positive definite.
  bool Factor(const BlockMatrix& matrix, double relative, double absolute);

  /// The x with `matrix * x == right`, after a successful Factor, to about six digits: a third of
  /// the time of all. Steps towards a minimum need no more, and gradients make it exact.
  std::vector<BlockVector> Solve(std::span<const BlockVector> right) const;

 private:
  /// Where the block of an edge begins its life as a block of L.
  struct Slot {
    std::uint32_t edge;
    std::uint32_t row;
    bool is_transposed;
  };

  void SortEdges(std::span<const BlockEdge> edges);
  void FindStructure();
  void PlaceColumns();
  void FindTargets();
  void StartColumn(std::uint32_t column, const BlockMatrix& matrix, double relative,
                   double absolute);
  bool FactorColumn(std::uint32_t column);

  std::span<const Slot> SlotsOf(std::uint32_t column) const {
    return std::span(slots_).subspan(slot_begin_[column],
                                     slot_begin_[column + 1] - slot_begin_[column]);
  }
  std::uint32_t CountBelow(std::uint32_t column) const {
    return begin_[column + 1] - begin_[column];
  }
  std::span<const std::uint32_t> RowsOf(std::uint32_t column) const {
    return std::span(rows_).subspan(begin_[column], CountBelow(column));
  }

  std::vector<std::uint32_t> unknown_at_;   // by position in the order of elimination
  std::vector<std::uint32_t> position_of_;  // by unknown
  std::vector<std::uint32_t> begin_;        // of each column's blocks below the diagonal
  std::vector<std::uint32_t> rows_;         // of those blocks, ascending in a column
  std::vector<std::uint32_t> slot_begin_;   // of each column's slots
  std::vector<Slot> slots_;
  // A column is worked on from the first that changes it until it is finished and has changed all
  // that it does. It begins with its diagonal.
  std::vector<std::uint32_t> working_begin_;  // of each column, in working_
  LargeVector<std::uint32_t> targets_;        // in working_, of each product of a column's blocks
  LargeVector<internal::PaddedBlock> working_;
  LargeVector<internal::RoughBlock> rough_blocks_;            // of L, below the diagonal
  std::vector<internal::RoughBlock> rough_inverse_diagonal_;  // of L
};

}  // namespace waymark::mapping
