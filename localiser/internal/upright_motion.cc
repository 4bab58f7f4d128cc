// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/upright_motion.h"

#include <cmath>

namespace waymark::localiser::internal {
namespace {

constexpr double kMinBaselineM = 0.7;  // of a sample, else its turn is noise
constexpr double kMaxStretch = 0.1;    // of a copy

}  // namespace

std::optional<UprightMotion> SolveUprightMotion(const PointPair& a, const PointPair& b) {
  const Eigen::Vector3d from = b.first - a.first, to = b.second - a.second;
  const double from_m = from.head<2>().norm(), to_m = to.head<2>().norm();
  if (from_m < kMinBaselineM || std::abs(to_m - from_m) > kMaxStretch * from_m + 0.1 ||
      std::abs(to.z() - from.z()) > kMaxStretch * from_m + 0.2) {
    return std::nullopt;
  }
  UprightMotion motion;
  const double scale = 1 / (from_m * to_m);
  motion.cos = scale * from.head<2>().dot(to.head<2>());
  motion.sin = scale * (from.x() * to.y() - from.y() * to.x());
  motion.place = (a.second + b.second - motion.Turn(a.first + b.first)) / 2;
  return motion;
}

std::optional<UprightMotion> FitUprightMotion(std::span<const PointPair> pairs) {
  if (pairs.size() < 3) return std::nullopt;
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
  for (const PointPair& pair : pairs) {
    from += pair.first;
    to += pair.second;
  }
  from /= static_cast<double>(pairs.size());
  to /= static_cast<double>(pairs.size());
  double along = 0, across = 0;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d a = pair.first - from, b = pair.second - to;
    along += a.x() * b.x() + a.y() * b.y();
    across += a.x() * b.y() - a.y() * b.x();
  }
  const double length = std::hypot(along, across);
  if (!(length > 0)) return std::nullopt;
  UprightMotion motion{along / length, across / length, {}};
  motion.place = to - motion.Turn(from);
  return motion;
}

}  // namespace waymark::localiser::internal
