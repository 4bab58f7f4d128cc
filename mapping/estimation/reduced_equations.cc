// SPDX-License-Identifier: Apache-2.0
#include "mapping/estimation/internal/reduced_equations.h"

#include <Eigen/Cholesky>

#include <algorithm>

namespace waymark::mapping::internal {
namespace {

/// Unknowns up to which a dense factorisation is the quicker one: 60 poses.
constexpr Eigen::Index kDenseUpTo = 360;

}  // namespace

ReducedEquations::ReducedEquations(std::span<const int> sizes, const BlockPattern& pattern)
    : sizes_(sizes), pattern_(pattern) {
  for (const int size : sizes_) {
    offsets_.push_back(static_cast<int>(unknowns_));
    unknowns_ += size;
  }
}

void ReducedEquations::AddTerm(const Eigen::VectorXd& residual, std::span<const Moved> moved,
                               BlockSums& sums) const {
  for (const Moved& a : moved) {
    if (a.block < 0) continue;
    const auto block_a = static_cast<std::size_t>(a.block);
    const Eigen::Index size = a.derivative.cols();
    Eigen::Map<Eigen::VectorXd>(&sums.right[kColumn * block_a], size) -=
        a.derivative.transpose() * residual;
    Eigen::Map<Eigen::VectorXd>(&sums.diagonals[kColumn * block_a], size) +=
        a.derivative.colwise().squaredNorm();
    for (const Moved& b : moved) {
      if (b.block < a.block) continue;
      double* target =
          &sums.blocks[kBlockDoubles * pattern_.Slot(block_a, static_cast<std::size_t>(b.block))];
      Eigen::Map<Eigen::Matrix<double, kColumn, kBlockSize>>(target).topLeftCorner(
          size, b.derivative.cols()) += a.derivative.transpose() * b.derivative;
    }
  }
}

/// Calls visit(row, column, value) for the lower triangle, column by column, rows ascending.
template <typename Visit>
void ReducedEquations::VisitLower(const BlockSums& sums, double damping, Visit visit) const {
  constexpr double kLeast = 1e-6;
  for (std::size_t a = 0; a < sizes_.size(); ++a) {
    for (int i = 0; i < sizes_[a]; ++i) {
      for (std::size_t b = a; b < sizes_.size(); ++b) {
        if (pattern_.slots[a * pattern_.block_count + b] < 0) continue;
        const double* block = &sums.blocks[kBlockDoubles * pattern_.Slot(a, b)];
        for (int j = a == b ? i : 0; j < sizes_[b]; ++j) {
          double value = block[kColumn * static_cast<std::size_t>(j) + static_cast<std::size_t>(i)];
          if (a == b && i == j) {
            value += damping *
                     std::max(sums.diagonals[kColumn * a + static_cast<std::size_t>(i)], kLeast);
          }
          visit(offsets_[b] + j, offsets_[a] + i, value);
        }
      }
    }
  }
}

std::optional<Eigen::VectorXd> ReducedEquations::SolveDense(const BlockSums& sums, double damping,
                                                            const Eigen::VectorXd& right) const {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(unknowns_, unknowns_);
  VisitLower(sums, damping,
             [&](int row, int column, double value) { matrix(row, column) = value; });
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(matrix);
  if (factors.info() != Eigen::Success) return std::nullopt;
  return factors.solve(right);
}

std::optional<Eigen::VectorXd> ReducedEquations::SolveSparse(const BlockSums& sums, double damping,
                                                             const Eigen::VectorXd& right) {
  std::vector<Eigen::Triplet<double>> entries;
  VisitLower(sums, damping,
             [&](int row, int column, double value) { entries.emplace_back(row, column, value); });
  Eigen::SparseMatrix<double> matrix(unknowns_, unknowns_);
  matrix.setFromTriplets(entries.begin(), entries.end());
  if (!is_analysed_) sparse_.analyzePattern(matrix);
  is_analysed_ = true;
  sparse_.factorize(matrix);
  if (sparse_.info() != Eigen::Success) return std::nullopt;
  return sparse_.solve(right);
}

std::optional<std::vector<double>> ReducedEquations::Solve(const BlockSums& sums, double damping) {
  std::vector<double> steps(kColumn * sizes_.size(), 0.0);
  if (unknowns_ == 0) return steps;
  Eigen::VectorXd right(unknowns_);
  for (std::size_t b = 0; b < sizes_.size(); ++b) {
    for (int i = 0; i < sizes_[b]; ++i) {
      right(offsets_[b] + i) = sums.right[kColumn * b + static_cast<std::size_t>(i)];
    }
  }
  const auto solution = unknowns_ <= kDenseUpTo ? SolveDense(sums, damping, right)
                                                : SolveSparse(sums, damping, right);
  if (!solution || !solution->allFinite()) return std::nullopt;
  for (std::size_t b = 0; b < sizes_.size(); ++b) {
    for (int i = 0; i < sizes_[b]; ++i) {
      steps[kColumn * b + static_cast<std::size_t>(i)] = (*solution)(offsets_[b] + i);
    }
  }
  return steps;
}

}  // namespace waymark::mapping::internal
