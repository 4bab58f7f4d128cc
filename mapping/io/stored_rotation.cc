// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/stored_rotation.h"

#include <array>
#include <cmath>
#include <cstdlib>

namespace waymark::mapping {
namespace {

bool IsSettled(const Eigen::Quaterniond& rotation) {
  return rotation.normalized().coeffs() == rotation.coeffs();
}

/// A number moved by units in the last place, away from zero when positive.
double Moved(double value, int steps) {
  const double towards = steps > 0 ? 2 * value : 0;
  for (int i = 0; i < std::abs(steps); ++i) value = std::nextafter(value, towards);
  return value;
}

/// One of the 625 neighbours whose components differ by at most two units in the last place.
Eigen::Quaterniond Neighbour(const Eigen::Quaterniond& rotation, int code) {
  constexpr std::array<int, 5> kSteps{0, -1, 1, -2, 2};
  Eigen::Quaterniond neighbour = rotation;
  for (int axis = 0; axis < 4; ++axis, code /= 5) {
    neighbour.coeffs()[axis] = Moved(rotation.coeffs()[axis], kSteps[code % 5]);
  }
  return neighbour;
}

}  // namespace

Eigen::Quaterniond StoredRotation(const Eigen::Quaterniond& rotation) {
  constexpr int kMaxIterations = 16;
  constexpr int kNeighbours = 625;
  Eigen::Quaterniond stored = rotation.normalized();
  for (int i = 0; i < kMaxIterations && !IsSettled(stored); ++i) stored = stored.normalized();
  // One in a hundred alternates between two values; one beside them has norm 1 as computed.
  for (int code = 0; code < kNeighbours; ++code) {
    Eigen::Quaterniond neighbour = Neighbour(stored, code);
    if (IsSettled(neighbour)) return neighbour;
  }
  return stored;
}

}  // namespace waymark::mapping
