// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "mapping/fusion/internal/block_cholesky.h"

namespace waymark::mapping {

/// A positive definite matrix as conjugate gradients see it: `matrix` with `(1 + relative) * d +
/// absolute` for every element d of its diagonal. Borrows both.
struct DampedMatrix {
  const BlockMatrix& matrix;
  std::span<const BlockEdge> edges;  ///< of its off-diagonal blocks
  double relative;
  double absolute;

  std::vector<BlockVector> Times(std::span<const BlockVector> x) const;
};

struct GradientsLimit {
  double accuracy;  ///< enough: the error is this share of the solution, in the matrix's norm
  int iterations;   ///< at most, >= 1
};

struct GradientsSolution {
  std::vector<BlockVector> x;
  double accuracy;  ///< before the last step
};

/// Nearly the x with `matrix * x == right`, found by steps that the factor of a similar matrix
/// directs: the more alike, the fewer. However few, `x` leads downhill.
/// Source: Saad, "Iterative Methods for Sparse Linear Systems", SIAM 2003, algorithm 9.1.
GradientsSolution SolveByGradients(const DampedMatrix& matrix, std::span<const BlockVector> right,
                                   const BlockCholesky& similar, const GradientsLimit& limit);

}  // namespace waymark::mapping
