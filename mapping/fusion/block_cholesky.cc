// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/block_cholesky.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "mapping/fusion/internal/working_runs.h"

namespace waymark::mapping {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

using internal::PaddedBlock;
using internal::RoughBlock;
using internal::RoughVector;

/// The block without its row of zeros.
auto Of(PaddedBlock& padded) {
  return Eigen::Map<Eigen::Matrix<double, 8, 7>>(&padded.at[0][0]).topRows<7>();
}
auto Of(RoughBlock& rough) {
  return Eigen::Map<Eigen::Matrix<float, 8, 7>>(&rough.at[0][0]).topRows<7>();
}
auto Of(const RoughBlock& rough) {
  return Eigen::Map<const Eigen::Matrix<float, 8, 7>>(&rough.at[0][0]).topRows<7>();
}
auto Of(RoughVector& rough) { return Eigen::Map<Eigen::Matrix<float, 8, 1>>(rough.at).head<7>(); }

}  // namespace

BlockCholesky::BlockCholesky(std::vector<std::uint32_t> order, std::span<const BlockEdge> edges)
    : unknown_at_(std::move(order)),
      position_of_(unknown_at_.size()),
      rough_inverse_diagonal_(unknown_at_.size()) {
  for (std::uint32_t i = 0; i < unknown_at_.size(); ++i) position_of_[unknown_at_[i]] = i;
  SortEdges(edges);
  FindStructure();
  PlaceColumns();
  FindTargets();
  rough_blocks_.resize(rows_.size());
}

/// Sorts edges by column.
void BlockCholesky::SortEdges(std::span<const BlockEdge> edges) {
  const auto positions = [&](const BlockEdge& edge) {
    return std::minmax({position_of_[edge.first], position_of_[edge.second]});
  };
  slot_begin_.assign(unknown_at_.size() + 1, 0);
  for (const BlockEdge& edge : edges) ++slot_begin_[positions(edge).first + 1];
  std::partial_sum(slot_begin_.begin(), slot_begin_.end(), slot_begin_.begin());
  std::vector<std::uint32_t> next(slot_begin_.begin(), slot_begin_.end() - 1);
  slots_.resize(edges.size());
  for (std::uint32_t k = 0; k < edges.size(); ++k) {
    const auto [column, row] = positions(edges[k]);
    slots_[next[column]++] = {k, row, position_of_[edges[k].first] < position_of_[edges[k].second]};
  }
}

void BlockCholesky::FindStructure() {
  const std::size_t size = unknown_at_.size();
  // A column of L holds what the matrix has there and what its children in the elimination tree
  // hold below their parent.
  std::vector<std::uint32_t> last_child(size, kNone), sibling(size, kNone), seen_by(size, kNone);
  begin_.assign(1, 0);
  for (std::uint32_t column = 0; column < size; ++column) {
    const auto begin = static_cast<std::ptrdiff_t>(rows_.size());
    const auto add = [&](std::uint32_t row) {
      if (row == column || seen_by[row] == column) return;
      seen_by[row] = column;
      rows_.push_back(row);
    };
    for (const Slot& slot : SlotsOf(column)) add(slot.row);
    for (std::uint32_t child = last_child[column]; child != kNone; child = sibling[child]) {
      for (std::uint32_t k = begin_[child]; k < begin_[child + 1]; ++k) add(rows_[k]);
    }
    std::sort(rows_.begin() + begin, rows_.end());
    begin_.push_back(static_cast<std::uint32_t>(rows_.size()));
    if (CountBelow(column) == 0) continue;
    const std::uint32_t parent = rows_[begin_[column]];
    sibling[column] = std::exchange(last_child[parent], column);
  }
}

void BlockCholesky::PlaceColumns() {
  const auto size = static_cast<std::uint32_t>(unknown_at_.size());
  working_begin_.assign(size, kNone);
  internal::WorkingRuns runs;
  const auto take = [&](std::uint32_t column) {
    if (working_begin_[column] != kNone) return;
    working_begin_[column] = runs.Take(1 + CountBelow(column));
  };
  for (std::uint32_t column = 0; column < size; ++column) {
    take(column);
    for (const std::uint32_t row : RowsOf(column)) take(row);
    runs.Give(working_begin_[column], 1 + CountBelow(column));
  }
  working_.resize(runs.extent());
}

void BlockCholesky::FindTargets() {
  std::size_t products = 0;
  for (std::uint32_t j = 0; j < unknown_at_.size(); ++j) {
    products += std::size_t{CountBelow(j)} * (CountBelow(j) + 1) / 2;
  }
  targets_.reserve(products);
  for (std::uint32_t j = 0; j < unknown_at_.size(); ++j) {
    for (std::uint32_t k = begin_[j]; k < begin_[j + 1]; ++k) {
      // What is below this row in its column is there in the row's own column, too.
      std::uint32_t in_rows = begin_[rows_[k]];
      const std::uint32_t diagonal = working_begin_[rows_[k]];
      targets_.push_back(diagonal);
      for (std::uint32_t below = k + 1; below < begin_[j + 1]; ++below, ++in_rows) {
        while (rows_[in_rows] != rows_[below]) ++in_rows;
        targets_.push_back(diagonal + 1 + in_rows - begin_[rows_[k]]);
      }
    }
  }
}

bool BlockCholesky::Factor(const BlockMatrix& matrix, double relative, double absolute) {
  const auto size = static_cast<std::uint32_t>(unknown_at_.size());
  std::vector<bool> has_started(size, false);
  const auto start = [&](std::uint32_t column) {
    if (has_started[column]) return;
    has_started[column] = true;
    StartColumn(column, matrix, relative, absolute);
  };
  // Right-looking: a column is in the cache when it is finished, and so are those that it changes,
  // for the columns before it in its part of the map have just changed them.
  const internal::BlockKernels& kernels = internal::ChosenBlockKernels();
  auto targets = targets_.begin();
  for (std::uint32_t j = 0; j < size; ++j) {
    start(j);
    if (!FactorColumn(j)) return false;
    for (const std::uint32_t row : RowsOf(j)) start(row);
    std::span<const PaddedBlock> below{working_.data() + working_begin_[j] + 1, CountBelow(j)};
    for (; !below.empty(); below = below.subspan(1)) {
      kernels.subtract_column(below, below.front(), {targets, targets + below.size()},
                              working_.data());
      targets += static_cast<std::ptrdiff_t>(below.size());
    }
  }
  return true;
}

void BlockCholesky::StartColumn(std::uint32_t column, const BlockMatrix& matrix, double relative,
                                double absolute) {
  const std::span<PaddedBlock> blocks{working_.data() + working_begin_[column],
                                      std::size_t{1} + CountBelow(column)};
  std::ranges::fill(blocks, PaddedBlock{});
  auto diagonal = Of(blocks.front());
  diagonal = matrix.diagonal[unknown_at_[column]];
  diagonal.diagonal() *= 1 + relative;
  diagonal.diagonal().array() += absolute;
  const std::span<const std::uint32_t> rows = RowsOf(column);
  for (const Slot& slot : SlotsOf(column)) {
    const auto at = std::ranges::lower_bound(rows, slot.row) - rows.begin();
    auto target = Of(blocks[static_cast<std::size_t>(1 + at)]);
    const Block& block = matrix.off_diagonal[slot.edge];
    if (slot.is_transposed) target = block.transpose();
    if (!slot.is_transposed) target = block;
  }
}

bool BlockCholesky::FactorColumn(std::uint32_t column) {
  PaddedBlock* const diagonal = working_.data() + working_begin_[column];
  const std::span<PaddedBlock> below{diagonal + 1, CountBelow(column)};
  const Eigen::LLT<Block> factor(Of(*diagonal));
  if (factor.info() != Eigen::Success) return false;
  Block inverse = Block::Identity();
  factor.matrixL().solveInPlace(inverse);
  Of(rough_inverse_diagonal_[column]) = inverse.cast<float>();
  PaddedBlock across{};
  Of(across) = -inverse;
  const internal::BlockKernels& kernels = internal::ChosenBlockKernels();
  for (PaddedBlock& block : below) {
    const PaddedBlock before = std::exchange(block, {});
    kernels.subtract_product(before, across, block);
  }
  kernels.round(below, rough_blocks_.data() + begin_[column]);
  return true;
}

std::vector<BlockVector> BlockCholesky::Solve(std::span<const BlockVector> right) const {
  const auto size = static_cast<std::uint32_t>(unknown_at_.size());
  const auto column = [&](std::uint32_t j) {
    return std::pair(std::span(rough_blocks_).subspan(begin_[j], CountBelow(j)), RowsOf(j));
  };
  const internal::BlockKernels& kernels = internal::ChosenBlockKernels();
  std::vector<RoughVector> x(size);
  for (std::size_t j = 0; j < size; ++j) Of(x[j]) = right[unknown_at_[j]].cast<float>();
  for (std::uint32_t j = 0; j < size; ++j) {
    Of(x[j]) = Of(rough_inverse_diagonal_[j]).lazyProduct(Of(x[j])).eval();
    const auto [blocks, rows] = column(j);
    kernels.subtract_downwards(blocks, rows, x[j], x.data());
  }
  std::vector<BlockVector> solution(size);
  for (std::uint32_t j = size; j-- > 0;) {
    const auto [blocks, rows] = column(j);
    kernels.subtract_upwards(blocks, rows, x.data(), x[j]);
    Of(x[j]) = Of(rough_inverse_diagonal_[j]).transpose().lazyProduct(Of(x[j])).eval();
    solution[unknown_at_[j]] = Of(x[j]).cast<double>();
  }
  return solution;
}

}  // namespace waymark::mapping
