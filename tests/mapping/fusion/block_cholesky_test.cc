// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "mapping/fusion/internal/conjugate_gradients.h"
#include "tests/mapping/fusion/random_system.h"

namespace waymark::mapping {
namespace {

TEST(EliminationOrder, HoldsEachUnknownOnceAndTheMiddleOfAChainLast) {
  std::vector<BlockEdge> edges;
  std::vector<Eigen::Vector2d> positions;
  for (std::uint32_t i = 0; i < 101; ++i) {
    positions.emplace_back(i, 0);
    if (i > 0) edges.push_back({i - 1, i});
  }
  std::vector<std::uint32_t> order = ChooseEliminationOrder(positions, edges);
  EXPECT_GE(order.back(), 29u);
  EXPECT_LE(order.back(), 71u);
  std::sort(order.begin(), order.end());
  for (std::uint32_t i = 0; i < 101; ++i) EXPECT_EQ(order[i], i);
  EXPECT_TRUE(ChooseEliminationOrder({}, {}).empty());
}

TEST(BlockCholesky, SolvesAsADenseSolverDoes) {
  for (const auto& [size, edges] : {std::pair(1, 0), std::pair(2, 1), std::pair(12, 0),
                                    std::pair(30, 40), std::pair(40, 300)}) {
    const RandomSystem system = MakeSystem(size, edges, 7);
    BlockCholesky cholesky(RandomOrder(size, system.edges), system.edges);
    ASSERT_TRUE(cholesky.Factor(system.matrix, 0.5, 0.25));
    Eigen::MatrixXd damped = system.dense;
    damped.diagonal() = 1.5 * damped.diagonal().array() + 0.25;
    const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(7 * size, -1, 2);
    std::vector<BlockVector> right_blocks(static_cast<std::size_t>(size));
    for (int i = 0; i < size; ++i)
      right_blocks[static_cast<std::size_t>(i)] = right.segment<7>(7 * i);
    const Eigen::VectorXd expected = damped.llt().solve(right);
    const auto expect_near = [&](const std::vector<BlockVector>& found, double error) {
      for (int i = 0; i < size; ++i) {
        EXPECT_LT((found[static_cast<std::size_t>(i)] - expected.segment<7>(7 * i)).norm(), error)
            << size << " unknowns, " << edges << " edges";
      }
    };
    expect_near(cholesky.Solve(right_blocks), 1e-5 * expected.norm());
    const DampedMatrix matrix{system.matrix, system.edges, 0.5, 0.25};
    expect_near(SolveByGradients(matrix, right_blocks, cholesky, {1e-12, 5}).x, 1e-9);
  }
}

TEST(BlockCholesky, FactorsAgainWithOtherNumbers) {
  RandomSystem system = MakeSystem(20, 40, 8);
  BlockCholesky cholesky(RandomOrder(20, system.edges), system.edges);
  const std::vector<BlockVector> right(20, BlockVector::Ones());
  ASSERT_TRUE(cholesky.Factor(system.matrix, 0, 0));
  const auto before = cholesky.Solve(right);
  for (Block& block : system.matrix.diagonal) block *= 4;
  for (Block& block : system.matrix.off_diagonal) block *= 4;
  ASSERT_TRUE(cholesky.Factor(system.matrix, 0, 0));
  const auto after = cholesky.Solve(right);
  for (std::size_t i = 0; i < 20; ++i) EXPECT_LT((4 * after[i] - before[i]).norm(), 1e-12);
}

TEST(BlockCholesky, RefusesWhatIsNotPositiveDefinite) {
  RandomSystem system = MakeSystem(10, 20, 9);
  system.matrix.diagonal[4](2, 2) = -1;
  BlockCholesky cholesky(RandomOrder(10, system.edges), system.edges);
  EXPECT_FALSE(cholesky.Factor(system.matrix, 0, 0));
}

}  // namespace
}  // namespace waymark::mapping
