// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/conjugate_gradients.h"

#include <cmath>

namespace waymark::mapping {
namespace {

double Dot(std::span<const BlockVector> a, std::span<const BlockVector> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

/// a += factor * b.
void Add(double factor, std::span<const BlockVector> b, std::span<BlockVector> a) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += factor * b[i];
}

}  // namespace

std::vector<BlockVector> DampedMatrix::Times(std::span<const BlockVector> x) const {
  std::vector<BlockVector> product(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Block& block = matrix.diagonal[i];
    product[i] =
        block.lazyProduct(x[i]) + relative * block.diagonal().cwiseProduct(x[i]) + absolute * x[i];
  }
  for (std::size_t k = 0; k < edges.size(); ++k) {
    const auto& [first, second] = edges[k];
    product[first] += matrix.off_diagonal[k].lazyProduct(x[second]);
    product[second] += matrix.off_diagonal[k].transpose().lazyProduct(x[first]);
  }
  return product;
}

GradientsSolution SolveByGradients(const DampedMatrix& matrix, std::span<const BlockVector> right,
                                   const BlockCholesky& similar, const GradientsLimit& limit) {
  GradientsSolution solution{std::vector<BlockVector>(right.size(), BlockVector::Zero()), 1};
  std::vector<BlockVector> residual(right.begin(), right.end()), direction;
  double whole = 0, last = 0;
  for (int i = 0; i < limit.iterations; ++i) {
    std::vector<BlockVector> towards = similar.Solve(residual);
    const double size = Dot(residual, towards);
    if (i == 0) {
      whole = size;
      direction = std::move(towards);
    } else {
      for (std::size_t k = 0; k < direction.size(); ++k) {
        direction[k] = towards[k] + size / last * direction[k];
      }
      solution.accuracy = std::sqrt(size / whole);
      if (solution.accuracy < limit.accuracy) break;
    }
    last = size;
    const std::vector<BlockVector> change = matrix.Times(direction);
    const double along = Dot(direction, change);
    if (!(along > 0)) break;  // there is nothing to do, or no number
    Add(size / along, direction, solution.x);
    Add(-size / along, change, residual);
  }
  return solution;
}

}  // namespace waymark::mapping
