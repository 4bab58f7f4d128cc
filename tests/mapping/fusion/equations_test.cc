// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/equations.h"

#include <gtest/gtest.h>

#include "mapping/fusion/internal/conjugate_gradients.h"
#include "mapping/fusion/internal/fusing.h"
#include "tests/mapping/fusion/city.h"
#include "tests/mapping/fusion/random_system.h"

namespace waymark::mapping {
namespace {

Eigen::VectorXd Flatten(const std::vector<BlockVector>& blocks) {
  Eigen::VectorXd whole(7 * static_cast<Eigen::Index>(blocks.size()));
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    whole.segment<7>(7 * static_cast<Eigen::Index>(i)) = blocks[i];
  }
  return whole;
}

/// The same matrix with each unknown's own block stiffer, by up to so many times.
BlockMatrix Stiffen(BlockMatrix matrix, double most) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> factor(1, most);
  for (Block& block : matrix.diagonal) block *= factor(random);
  return matrix;
}

TEST(ConjugateGradients, AFactorOfTheSameMatrixEndsThemAtOnce) {
  const RandomSystem system = MakeSystem(30, 60, 3);
  BlockCholesky factor(RandomOrder(30, system.edges), system.edges);
  ASSERT_TRUE(factor.Factor(system.matrix, 0.5, 0.25));
  const std::vector<BlockVector> right(30, BlockVector::Ones());
  const DampedMatrix matrix{system.matrix, system.edges, 0.5, 0.25};
  const GradientsSolution solution = SolveByGradients(matrix, right, factor, {1e-9, 5});
  EXPECT_LT((Flatten(matrix.Times(solution.x)) - Flatten(right)).norm(), 1e-9);
  EXPECT_LT(solution.accuracy, 1e-9);
}

TEST(ConjugateGradients, AFactorOfASimilarMatrixLeadsToTheSolution) {
  const RandomSystem system = MakeSystem(30, 60, 4);
  BlockCholesky similar(RandomOrder(30, system.edges), system.edges);
  ASSERT_TRUE(similar.Factor(Stiffen(system.matrix, 3), 0, 0));
  const std::vector<BlockVector> right(30, BlockVector::Ones());
  const DampedMatrix matrix{system.matrix, system.edges, 0, 0};
  const Eigen::VectorXd expected = system.dense.llt().solve(Flatten(right));
  double before = expected.norm();
  for (const int iterations : {1, 2, 4, 8, 16}) {
    const GradientsSolution solution =
        SolveByGradients(matrix, right, similar, {1e-12, iterations});
    const Eigen::VectorXd error = Flatten(solution.x) - expected;
    EXPECT_LT(error.norm(), before);
    EXPECT_GT(Flatten(solution.x).dot(Flatten(right)), 0) << "it leads downhill";
    before = error.norm();
  }
  EXPECT_LT(before, 1e-4 * expected.norm());
}

TEST(ConjugateGradients, NothingToDoIsNothing) {
  const RandomSystem system = MakeSystem(5, 6, 5);
  BlockCholesky factor(RandomOrder(5, system.edges), system.edges);
  ASSERT_TRUE(factor.Factor(system.matrix, 0, 0));
  const std::vector<BlockVector> right(5, BlockVector::Zero());
  const DampedMatrix matrix{system.matrix, system.edges, 0, 0};
  EXPECT_EQ(Flatten(SolveByGradients(matrix, right, factor, {0.1, 3}).x).norm(), 0);
}

/// Some of a city's submaps move, among them some that are held in the equations.
TEST(Equations, FollowingIsLookingAtAllAgain) {
  const City city = MakeCity({.submaps = 80, .wrong_overlaps = 0.1});
  const FusionOptions options;
  const Fusing fusing = *BeginFusing(city.submaps, options);
  std::vector<bool> is_free = fusing.is_movable;
  for (std::size_t i = 0; i < is_free.size(); i += 5) is_free[i] = false;
  std::vector<Place> moved = fusing.places;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, 0.05);
  for (std::size_t i = 0; i < moved.size(); i += 3) {
    moved[i].Move(BlockVector::NullaryExpr([&] { return normal(random); }));
  }
  for (const OverlapLoss loss : {OverlapLoss::kHuber, OverlapLoss::kCauchy}) {
    Equations following(fusing.terms, is_free, fusing.places, options);
    Equations looking(fusing.terms, is_free, fusing.places, options);
    const double before = following.Linearise(fusing.places, loss);
    const double growth = following.Follow(fusing.places, moved, loss);
    const double after = looking.Linearise(moved, loss);
    EXPECT_NEAR(before + growth, after, 1e-9 * after);
    const Eigen::VectorXd expected = Flatten(*looking.FindStep(0));
    EXPECT_LT((Flatten(*following.FindStep(0)) - expected).norm(), 1e-8 * expected.norm());
  }
}

}  // namespace
}  // namespace waymark::mapping
