// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "mapping/fusion/internal/block_cholesky.h"

namespace waymark::mapping {

struct RandomSystem {
  std::vector<BlockEdge> edges;
  BlockMatrix matrix;
  Eigen::MatrixXd dense;
};

/// Positive definite, as every edge adds J^T J with J over both its unknowns.
inline RandomSystem MakeSystem(int size, int edge_count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> any(0, size - 1);
  RandomSystem system;
  system.matrix.diagonal.assign(static_cast<std::size_t>(size), Block::Identity());
  std::set<std::pair<int, int>> seen;
  for (int e = 0; e < edge_count; ++e) {
    const int a = any(random), b = any(random);
    if (a == b || !seen.insert(std::minmax(a, b)).second) continue;
    const Eigen::Matrix<double, 7, 14> j = Eigen::Matrix<double, 7, 14>::NullaryExpr(
        [&] { return std::normal_distribution<double>()(random); });
    system.edges.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)});
    system.matrix.diagonal[static_cast<std::size_t>(a)] +=
        j.leftCols<7>().transpose() * j.leftCols<7>();
    system.matrix.diagonal[static_cast<std::size_t>(b)] +=
        j.rightCols<7>().transpose() * j.rightCols<7>();
    system.matrix.off_diagonal.push_back(j.leftCols<7>().transpose() * j.rightCols<7>());
  }
  system.dense.setZero(7 * size, 7 * size);
  for (int i = 0; i < size; ++i) {
    system.dense.block<7, 7>(7 * i, 7 * i) = system.matrix.diagonal[static_cast<std::size_t>(i)];
  }
  for (std::size_t e = 0; e < system.edges.size(); ++e) {
    const auto a = static_cast<int>(system.edges[e].first);
    const auto b = static_cast<int>(system.edges[e].second);
    system.dense.block<7, 7>(7 * a, 7 * b) = system.matrix.off_diagonal[e];
    system.dense.block<7, 7>(7 * b, 7 * a) = system.matrix.off_diagonal[e].transpose();
  }
  return system;
}

/// As if the unknowns lay anywhere.
inline std::vector<std::uint32_t> RandomOrder(int size, const std::vector<BlockEdge>& edges) {
  std::vector<Eigen::Vector2d> positions(static_cast<std::size_t>(size));
  for (Eigen::Vector2d& position : positions) position.setRandom();
  return ChooseEliminationOrder(positions, edges);
}

}  // namespace waymark::mapping
