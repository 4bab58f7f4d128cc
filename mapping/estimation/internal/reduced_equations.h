// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/estimation/internal/point_elimination.h"

namespace waymark::mapping::internal {

/// The equations of poses and cameras once points are eliminated: positive definite, in blocks.
/// Few are solved dense, many sparse.
class ReducedEquations {
 public:
  /// Borrows. `sizes`: unknowns of each block, 1 to kBlockSize. Every block has its own square.
  ReducedEquations(std::span<const int> sizes, const BlockPattern& pattern);

  /// Adds a term that moves several blocks: residual and derivative by each, weighted.
  struct Moved {
    std::int32_t block;  ///< -1: held
    Eigen::MatrixXd derivative;
  };
  void AddTerm(const Eigen::VectorXd& residual, std::span<const Moved> moved,
               BlockSums& sums) const;

  /// Steps of all blocks, kColumn each; damping multiplies the diagonal of the equations before
  /// points were eliminated. nullopt: not positive definite.
  std::optional<std::vector<double>> Solve(const BlockSums& sums, double damping);

 private:
  template <typename Visit>
  void VisitLower(const BlockSums& sums, double damping, Visit visit) const;
  std::optional<Eigen::VectorXd> SolveDense(const BlockSums& sums, double damping,
                                            const Eigen::VectorXd& right) const;
  std::optional<Eigen::VectorXd> SolveSparse(const BlockSums& sums, double damping,
                                             const Eigen::VectorXd& right);

  std::span<const int> sizes_;
  std::vector<int> offsets_;  // of each block's first unknown
  const BlockPattern& pattern_;
  Eigen::Index unknowns_ = 0;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> sparse_;
  bool is_analysed_ = false;
};

}  // namespace waymark::mapping::internal
