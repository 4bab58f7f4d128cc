// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/equations.h"

#include <gtest/gtest.h>

#include <algorithm>

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

/// Every fifth submap of a city is held, and the equations of the others stand at first guesses.
class EquationsOfPart : public testing::TestWithParam<OverlapLoss> {
 protected:
  EquationsOfPart() {
    is_free_ = fusing_.is_movable;
    for (std::size_t i = 0; i < is_free_.size(); i += 5) is_free_[i] = false;
  }

  Equations EquationsOf(const std::vector<bool>& is_free) const {
    return {fusing_.terms, is_free, fusing_.places, options_};
  }

  /// Those nearer to the corner of the city than the submap of this index.
  std::vector<bool> FreeUpTo(std::size_t index) const {
    std::vector<bool> is_free = is_free_;
    std::fill(is_free.begin() + static_cast<std::ptrdiff_t>(index), is_free.end(), false);
    return is_free;
  }

  void Move(const std::vector<bool>& is_moving) {
    std::normal_distribution<double> normal(0, 0.05);
    for (std::size_t i = 0; i < is_moving.size(); ++i) {
      if (!is_moving[i]) continue;
      fusing_.places[i].Move(BlockVector::NullaryExpr([&] { return normal(random_); }));
    }
  }

  /// That these equations and their cost are what all of them linearised here are.
  void ExpectAsLinearised(Equations& equations, const std::vector<bool>& is_free, double cost) {
    Equations anew = EquationsOf(is_free);
    const double expected_cost = anew.Linearise(fusing_.places, GetParam());
    EXPECT_NEAR(cost, expected_cost, 1e-9 * expected_cost);
    const Eigen::VectorXd expected = Flatten(*anew.FindStep(0));
    EXPECT_LT((Flatten(*equations.FindStep(0)) - expected).norm(), 1e-8 * expected.norm());
  }

  City city_ = MakeCity({.submaps = 80, .wrong_overlaps = 0.1});
  FusionOptions options_;
  Fusing fusing_ = *BeginFusing(city_.submaps, options_);
  std::vector<bool> is_free_;
  std::mt19937_64 random_{3};
};

TEST_P(EquationsOfPart, BeginAsLinearised) {
  Equations whole = EquationsOf(is_free_);
  whole.Linearise(fusing_.places, GetParam());
  Equations part = EquationsOf(FreeUpTo(40));
  const double cost = part.BeginAsPart(whole, fusing_.places, GetParam());
  ExpectAsLinearised(part, FreeUpTo(40), cost);
}

TEST_P(EquationsOfPart, FollowingThemIsLookingAtAllAgain) {
  Equations whole = EquationsOf(is_free_);
  double cost = whole.Linearise(fusing_.places, GetParam());
  Equations part = EquationsOf(FreeUpTo(40));
  part.BeginAsPart(whole, fusing_.places, GetParam());
  for (int i = 0; i < 2; ++i) {
    Move(FreeUpTo(40));
    part.Linearise(fusing_.places, GetParam());
  }
  cost += whole.Follow(part);
  ExpectAsLinearised(whole, is_free_, cost);
}

TEST_P(EquationsOfPart, APartFollowsItsOwnPartFirst) {
  Equations whole = EquationsOf(is_free_);
  double cost = whole.Linearise(fusing_.places, GetParam());
  Equations part = EquationsOf(FreeUpTo(40));
  double part_cost = part.BeginAsPart(whole, fusing_.places, GetParam());
  Move(FreeUpTo(40));
  part_cost = part.Linearise(fusing_.places, GetParam());
  std::vector<bool> few = FreeUpTo(40);
  std::fill(few.begin(), few.begin() + 30, false);  // beside what the part holds, too
  Equations of_few = EquationsOf(few);
  of_few.BeginAsPart(part, fusing_.places, GetParam());
  Move(few);
  of_few.Linearise(fusing_.places, GetParam());
  part_cost += part.Follow(of_few);
  ExpectAsLinearised(part, FreeUpTo(40), part_cost);
  cost += whole.Follow(part);
  ExpectAsLinearised(whole, is_free_, cost);
}

TEST_P(EquationsOfPart, NothingMovedIsNothingNew) {
  Equations whole = EquationsOf(is_free_);
  const double cost = whole.Linearise(fusing_.places, GetParam());
  Equations part = EquationsOf(FreeUpTo(40));
  part.BeginAsPart(whole, fusing_.places, GetParam());
  EXPECT_EQ(whole.Follow(part), 0);
  ExpectAsLinearised(whole, is_free_, cost);
}

INSTANTIATE_TEST_SUITE_P(BothLosses, EquationsOfPart,
                         testing::Values(OverlapLoss::kHuber, OverlapLoss::kCauchy));

}  // namespace
}  // namespace waymark::mapping
