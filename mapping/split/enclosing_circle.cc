// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "mapping/split/internal/enclosing_circle.h"

namespace waymark::mapping {
namespace {

Circle Around(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return {(a + b) / 2, (a - b).norm() / 2};
}

Circle Through(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d ab = b - a;
  const Eigen::Vector2d ac = c - a;
  const double twice_area = 2 * (ab.x() * ac.y() - ab.y() * ac.x());
  // Nearly on a line: the widest pair's circle holds the third up to rounding.
  if (std::abs(twice_area) <= 1e-12 * (ab.squaredNorm() + ac.squaredNorm())) {
    Circle widest = Around(a, b);
    for (const Circle& other : {Around(a, c), Around(b, c)}) {
      if (other.radius > widest.radius) widest = other;
    }
    return widest;
  }
  const Eigen::Vector2d centre_from_a(
      (ac.y() * ab.squaredNorm() - ab.y() * ac.squaredNorm()) / twice_area,
      (ab.x() * ac.squaredNorm() - ac.x() * ab.squaredNorm()) / twice_area);
  return {a + centre_from_a, centre_from_a.norm()};
}

}  // namespace

Circle ComputeEnclosingCircle(std::span<const Eigen::Vector2d> ordered_points) {
  if (ordered_points.empty()) return {};
  // Random order makes the expected time linear; sorted input would make it quadratic.
  std::vector<Eigen::Vector2d> points(ordered_points.begin(), ordered_points.end());
  std::mt19937_64 random(1);
  for (std::size_t i = points.size(); i > 1; --i) std::swap(points[i - 1], points[random() % i]);
  Circle circle{points[0], 0};
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (circle.Contains(points[i])) continue;
    circle = {points[i], 0};
    for (std::size_t j = 0; j < i; ++j) {
      if (circle.Contains(points[j])) continue;
      circle = Around(points[i], points[j]);
      for (std::size_t k = 0; k < j; ++k) {
        if (!circle.Contains(points[k])) circle = Through(points[i], points[j], points[k]);
      }
    }
  }
  return circle;
}

}  // namespace waymark::mapping
