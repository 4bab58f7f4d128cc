// SPDX-License-Identifier: Apache-2.0
#include "mapping/fusion/internal/terms.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "tests/mapping/fusion/street.h"

namespace waymark::mapping {
namespace {

constexpr double kStep = 1e-6;

BlockVector Differentiate(const std::function<double(const Place&)>& cost, const Place& at) {
  BlockVector gradient;
  for (int i = 0; i < 7; ++i) {
    Place ahead = at, behind = at;
    ahead.Move(kStep * BlockVector::Unit(i));
    behind.Move(-kStep * BlockVector::Unit(i));
    gradient[i] = (cost(ahead) - cost(behind)) / (2 * kStep);
  }
  return gradient;
}

Block DifferentiateTwice(const std::function<BlockVector(const Place&)>& gradient,
                         const Place& at) {
  Block matrix;
  for (int i = 0; i < 7; ++i) {
    Place ahead = at, behind = at;
    ahead.Move(kStep * BlockVector::Unit(i));
    behind.Move(-kStep * BlockVector::Unit(i));
    matrix.col(i) = (gradient(ahead) - gradient(behind)) / (2 * kStep);
  }
  return matrix;
}

/// Two places and the images both see; `noise` in metres, a tenth of it in radians.
struct Pair {
  Place first, second;
  std::vector<CommonImage> images;
  OverlapTerm term{.first = 0, .second = 1, .images = {}, .all_images = {}};
};

Pair MakePair(double noise) {
  std::mt19937_64 random(3);
  Pair pair;
  pair.first = {RotationFromVector({0.3, -0.2, 1}), {5, 6, 7}, 0.1};
  pair.second = {RotationFromVector({-1, 0.4, 0.2}), {9, 2, 8}, -0.2};
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector3d in_map = Eigen::Vector3d(7, 4, 7) + Gaussian3(random, 6);
    const auto arm = [&](const Place& place) -> Eigen::Vector3d {
      return place.MapFromArm().inverse() * (in_map - place.centroid_in_map);
    };
    pair.images.push_back({arm(pair.first), arm(pair.second) + Gaussian3(random, noise),
                           RotationFromVector(Gaussian3(random, noise / 10)) *
                               pair.second.rotation.conjugate() * pair.first.rotation});
  }
  pair.term.images = pair.images;
  return pair;
}

OverlapEquations LineariseAt(const Pair& pair, OverlapLoss loss) {
  OverlapEquations equations;
  Linearise(pair.term, pair.first, pair.second, loss, {}, equations);
  return equations;
}

TEST(FusionTerms, OverlapGradientIsTheCostsDerivative) {
  for (const OverlapLoss loss : {OverlapLoss::kHuber, OverlapLoss::kCauchy}) {
    for (const double noise : {0.02, 0.3, 8.0}) {
      Pair pair = MakePair(noise);
      pair.term.spread = 1.7;
      const OverlapEquations equations = LineariseAt(pair, loss);
      const auto cost = [&](const Place& first, const Place& second) {
        Pair moved = pair;
        moved.first = first, moved.second = second;
        return LineariseAt(moved, loss).cost;
      };
      const BlockVector by_first =
          Differentiate([&](const Place& place) { return cost(place, pair.second); }, pair.first);
      const BlockVector by_second =
          Differentiate([&](const Place& place) { return cost(pair.first, place); }, pair.second);
      const double size = 1 + by_first.norm() + by_second.norm();
      EXPECT_LT((equations.gradient_first - by_first).norm(), 1e-5 * size) << noise;
      EXPECT_LT((equations.gradient_second - by_second).norm(), 1e-5 * size) << noise;
    }
  }
}

TEST(FusionTerms, OverlapMatrixIsTheSecondDerivativeWhereImagesAgree) {
  const Pair pair = MakePair(0);
  const OverlapEquations equations = LineariseAt(pair, OverlapLoss::kHuber);
  EXPECT_LT(equations.cost, 1e-12);
  const auto at_first = [&](const Place& place) {
    Pair moved = pair;
    moved.first = place;
    return LineariseAt(moved, OverlapLoss::kHuber);
  };
  const Block first = DifferentiateTwice(
      [&](const Place& place) { return at_first(place).gradient_first; }, pair.first);
  const Block cross_transposed = DifferentiateTwice(
      [&](const Place& place) { return at_first(place).gradient_second; }, pair.first);
  const Block second = DifferentiateTwice(
      [&](const Place& place) {
        Pair moved = pair;
        moved.second = place;
        return LineariseAt(moved, OverlapLoss::kHuber).gradient_second;
      },
      pair.second);
  EXPECT_LT((equations.first - first).norm(), 1e-4 * first.norm());
  EXPECT_LT((equations.second - second).norm(), 1e-4 * second.norm());
  EXPECT_LT((equations.cross.transpose() - cross_transposed).norm(),
            1e-4 * cross_transposed.norm());
}

TEST(FusionTerms, SubmapGradientIsTheCostsDerivative) {
  std::mt19937_64 random(4);
  SubmapTerm term;
  term.fix_weight = 0.4;
  term.gravity_sigma_rad = 0.02;
  term.up_in_map = Eigen::Vector3d(0.1, -0.2, 1).normalized();
  term.log_scale = 0.05;
  term.scale_sigma = 0.01;
  for (int i = 0; i < 10; ++i) {
    term.fixes.push_back({Gaussian3(random, 5), Gaussian3(random, 5), 0.5});
  }
  const Place place{RotationFromVector({0.3, -0.2, 0.6}), {1, 2, 0}, 0.1};
  Block matrix = Block::Zero();
  BlockVector gradient = BlockVector::Zero();
  AddSubmapTerm(term, place, {}, matrix, gradient);
  const BlockVector expected = Differentiate(
      [&](const Place& at) {
        Block unused_matrix = Block::Zero();
        BlockVector unused_gradient = BlockVector::Zero();
        return AddSubmapTerm(term, at, {}, unused_matrix, unused_gradient);
      },
      place);
  EXPECT_LT((gradient - expected).norm(), 1e-6 * expected.norm());
}

TEST(FusionTerms, APlaceIsTheSimilarityItWasMadeFrom) {
  const Sim3 sim(1.7, RotationFromVector({1, 2, 0.3}), {100, -50, 3});
  const Eigen::Vector3d centroid(4, 5, 6), x(7, -8, 9);
  EXPECT_LT((Place::FromSim3(sim, centroid).ToSim3(centroid) * x - sim * x).norm(), 1e-12);
}

}  // namespace
}  // namespace waymark::mapping
