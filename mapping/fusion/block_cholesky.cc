// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/block_cholesky.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <utility>

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
      diagonal_(unknown_at_.size()),
      rough_inverse_diagonal_(unknown_at_.size()) {
  for (std::uint32_t i = 0; i < unknown_at_.size(); ++i) position_of_[unknown_at_[i]] = i;
  FindStructure(edges);
}

void BlockCholesky::FindStructure(std::span<const BlockEdge> edges) {
  const std::size_t size = unknown_at_.size();
  std::vector<std::vector<std::uint32_t>> below(size);
  for (const BlockEdge& edge : edges) {
    const auto [column, row] = std::minmax(position_of_[edge.first], position_of_[edge.second]);
    below[column].push_back(row);
  }
  // A column of L holds what the matrix has there and what its children in the elimination tree
  // hold below their parent.
  std::vector<std::vector<std::uint32_t>> children(size);
  std::vector<std::uint32_t> seen_by(size, kNone);
  begin_.assign(1, 0);
  for (std::uint32_t column = 0; column < size; ++column) {
    const auto begin = static_cast<std::ptrdiff_t>(rows_.size());
    const auto add = [&](std::uint32_t row) {
      if (row == column || seen_by[row] == column) return;
      seen_by[row] = column;
      rows_.push_back(row);
    };
    for (const std::uint32_t row : below[column]) add(row);
    for (const std::uint32_t child : children[column]) {
      for (std::uint32_t k = begin_[child]; k < begin_[child + 1]; ++k) add(rows_[k]);
    }
    std::sort(rows_.begin() + begin, rows_.end());
    begin_.push_back(static_cast<std::uint32_t>(rows_.size()));
    if (begin_[column] < begin_[column + 1]) children[rows_[begin_[column]]].push_back(column);
  }
  FindTargets();
  blocks_.resize(rows_.size());
  rough_blocks_.resize(rows_.size());
  for (const BlockEdge& edge : edges) {
    const std::uint32_t first = position_of_[edge.first], second = position_of_[edge.second];
    const auto [column, row] = std::minmax(first, second);
    const auto found =
        std::lower_bound(rows_.begin() + begin_[column], rows_.begin() + begin_[column + 1], row);
    slots_.push_back({static_cast<std::uint32_t>(found - rows_.begin()), first < second});
  }
}

void BlockCholesky::FindTargets() {
  for (std::uint32_t j = 0; j < unknown_at_.size(); ++j) {
    for (std::uint32_t k = begin_[j]; k < begin_[j + 1]; ++k) {
      // What is below this row in its column is there in the row's own column, too.
      std::uint32_t target = begin_[rows_[k]];
      for (std::uint32_t below = k + 1; below < begin_[j + 1]; ++below, ++target) {
        while (rows_[target] != rows_[below]) ++target;
        targets_.push_back(target);
      }
    }
  }
}

bool BlockCholesky::Factor(const BlockMatrix& matrix, double relative, double absolute) {
  const auto size = static_cast<std::uint32_t>(unknown_at_.size());
  for (std::uint32_t i = 0; i < size; ++i) {
    diagonal_[i] = {};
    auto block = Of(diagonal_[i]);
    block = matrix.diagonal[unknown_at_[i]];
    block.diagonal() *= 1 + relative;
    block.diagonal().array() += absolute;
  }
  for (PaddedBlock& block : blocks_) block = {};
  for (std::size_t k = 0; k < slots_.size(); ++k) {
    const Block& block = matrix.off_diagonal[k];
    auto target = Of(blocks_[slots_[k].block]);
    if (slots_[k].is_transposed) target = block.transpose();
    if (!slots_[k].is_transposed) target = block;
  }
  // Right-looking: a column is in the cache when it is finished, and so are those that it changes,
  // for the columns before it in its part of the map have just changed them.
  const internal::BlockKernels& kernels = internal::ChosenBlockKernels();
  auto targets = targets_.begin();
  for (std::uint32_t j = 0; j < size; ++j) {
    if (!FactorColumn(j)) return false;
    for (std::uint32_t k = begin_[j]; k < begin_[j + 1]; ++k) {
      const std::size_t below = k + 1, count = begin_[j + 1] - below;
      kernels.subtract_product(blocks_[k], blocks_[k], diagonal_[rows_[k]]);
      kernels.subtract_column({blocks_.data() + below, count}, blocks_[k],
                              {targets, targets + count}, blocks_.data());
      targets += static_cast<std::ptrdiff_t>(count);
    }
  }
  return true;
}

bool BlockCholesky::FactorColumn(std::uint32_t column) {
  const Eigen::LLT<Block> factor(Of(diagonal_[column]));
  if (factor.info() != Eigen::Success) return false;
  Block inverse = Block::Identity();
  factor.matrixL().solveInPlace(inverse);
  Of(rough_inverse_diagonal_[column]) = inverse.cast<float>();
  PaddedBlock across{};
  Of(across) = -inverse;
  const internal::BlockKernels& kernels = internal::ChosenBlockKernels();
  for (std::uint32_t k = begin_[column]; k < begin_[column + 1]; ++k) {
    const PaddedBlock block = blocks_[k];
    blocks_[k] = {};
    kernels.subtract_product(block, across, blocks_[k]);
  }
  const std::size_t count = begin_[column + 1] - begin_[column];
  kernels.round({blocks_.data() + begin_[column], count}, rough_blocks_.data() + begin_[column]);
  return true;
}

std::vector<BlockVector> BlockCholesky::Solve(std::span<const BlockVector> right) const {
  const std::size_t size = unknown_at_.size();
  const auto column = [&](std::size_t j) {
    return std::pair(std::span(rough_blocks_).subspan(begin_[j], begin_[j + 1] - begin_[j]),
                     std::span(rows_).subspan(begin_[j], begin_[j + 1] - begin_[j]));
  };
  const internal::BlockKernels& kernels = internal::ChosenBlockKernels();
  std::vector<RoughVector> x(size);
  for (std::size_t j = 0; j < size; ++j) Of(x[j]) = right[unknown_at_[j]].cast<float>();
  for (std::size_t j = 0; j < size; ++j) {
    Of(x[j]) = Of(rough_inverse_diagonal_[j]).lazyProduct(Of(x[j])).eval();
    const auto [blocks, rows] = column(j);
    kernels.subtract_downwards(blocks, rows, x[j], x.data());
  }
  std::vector<BlockVector> solution(size);
  for (std::size_t j = size; j-- > 0;) {
    const auto [blocks, rows] = column(j);
    kernels.subtract_upwards(blocks, rows, x.data(), x[j]);
    Of(x[j]) = Of(rough_inverse_diagonal_[j]).transpose().lazyProduct(Of(x[j])).eval();
    solution[unknown_at_[j]] = Of(x[j]).cast<double>();
  }
  return solution;
}

}  // namespace waymark::mapping
