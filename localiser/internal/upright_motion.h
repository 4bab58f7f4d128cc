// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <optional>
#include <span>
#include <utility>

namespace waymark::localiser::internal {

/// A turn about the vertical and a shift: to = turn * from + place. What is copied in a street
/// stands upright in both places. Both frames have z up.
struct UprightMotion {
  double cos = 1, sin = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();

  Eigen::Vector3d Turn(const Eigen::Vector3d& v) const {
    return {cos * v.x() - sin * v.y(), sin * v.x() + cos * v.y(), v.z()};
  }
  Eigen::Vector3d TurnBack(const Eigen::Vector3d& v) const {
    return {cos * v.x() + sin * v.y(), -sin * v.x() + cos * v.y(), v.z()};
  }
};

/// A point beside its copy.
using PointPair = std::pair<Eigen::Vector3d, Eigen::Vector3d>;  // from, to

/// The motion that two pairs of points fit; nullopt when they are too near to each other to tell
/// the turn, or no rigid upright copy of each other.
std::optional<UprightMotion> SolveUprightMotion(const PointPair& a, const PointPair& b);

/// The motion of least squares; nullopt for fewer than three pairs, or all above each other.
std::optional<UprightMotion> FitUprightMotion(std::span<const PointPair> pairs);

}  // namespace waymark::localiser::internal
