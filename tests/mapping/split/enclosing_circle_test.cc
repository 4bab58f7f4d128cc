// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "mapping/split/internal/enclosing_circle.h"

namespace waymark::mapping {
namespace {

TEST(EnclosingCircle, OfOnePointIsThatPoint) {
  const std::vector<Eigen::Vector2d> points{{3, 4}};
  const Circle circle = ComputeEnclosingCircle(points);
  EXPECT_EQ(circle.centre, Eigen::Vector2d(3, 4));
  EXPECT_EQ(circle.radius, 0);
}

TEST(EnclosingCircle, OfALineIsItsLength) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= 100; ++i) points.emplace_back(i, 2 * i);
  const Circle circle = ComputeEnclosingCircle(points);
  EXPECT_NEAR(circle.radius, std::hypot(50, 100), 1e-9);
  EXPECT_NEAR((circle.centre - Eigen::Vector2d(50, 100)).norm(), 0, 1e-9);
}

TEST(EnclosingCircle, SurvivesEqualPoints) {
  const std::vector<Eigen::Vector2d> points(50, Eigen::Vector2d(1e5, -1e5));
  EXPECT_NEAR(ComputeEnclosingCircle(points).radius, 0, 1e-9);
}

TEST(EnclosingCircle, ContainsAllPointsAndIsSmallest) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(-100, 100);
  for (int round = 0; round < 50; ++round) {
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < 3 + round; ++i) points.emplace_back(coordinate(random), coordinate(random));
    const Circle circle = ComputeEnclosingCircle(points);
    for (const auto& p : points) EXPECT_LE((p - circle.centre).norm(), circle.radius + 1e-7);
    // No centre nearby does better.
    for (int k = 0; k < 16; ++k) {
      const double angle = k * 0.3927;
      const Eigen::Vector2d centre =
          circle.centre + 0.05 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      double radius = 0;
      for (const auto& p : points) radius = std::max(radius, (p - centre).norm());
      EXPECT_GT(radius, circle.radius - 1e-9);
    }
  }
}

}  // namespace
}  // namespace waymark::mapping
