// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/gravity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/random_geometry.h"

namespace waymark::localiser::internal {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr Angle kSigma = Angle::Degrees(1);

/// A camera that looks at a wall: who leans by it seems to stand higher, or nearer the side.
Matrix6 Covariance(double lean_sigma_rad) {
  constexpr double kDistanceM = 12;
  Matrix6 covariance = 1e-4 * Matrix6::Identity();
  for (const auto& [turn, step] : {std::pair{3, 2}, std::pair{4, 0}}) {
    Vector6 lean = Vector6::Zero();
    lean(turn) = lean_sigma_rad;
    lean(step) = kDistanceM * lean_sigma_rad;
    covariance += lean * lean.transpose();
  }
  return covariance;
}

TEST(Gravity, TellsALeanFromAStep) {
  support::RandomGeometry random(1);
  const Rigid3 truth = random.Rigid();
  Vector6 lean = Vector6::Zero();
  lean(3) = 0.06;
  lean(2) = 12 * 0.06;
  const UncertainPose seen{Perturb(truth, lean), Covariance(0.05)};
  const Eigen::Vector3d up = truth.rotation().conjugate() * Eigen::Vector3d::UnitZ();
  const UncertainPose heeded = WithGravity(seen, up, kSigma);
  EXPECT_LT(Difference(truth, heeded.map_from_camera).norm(), 0.2 * lean.norm());
  EXPECT_LT(heeded.covariance(2, 2), 0.15 * seen.covariance(2, 2));
  EXPECT_GT(heeded.covariance.ldlt().vectorD().minCoeff(), 0);
}

TEST(Gravity, SaysNothingOfThatWhichImagesKnowBetter) {
  support::RandomGeometry random(2);
  const Rigid3 truth = random.Rigid();
  const Eigen::Vector3d wrong_up = RotationFromVector(Eigen::Vector3d(0.03, -0.02, 0.01)) *
                                   (truth.rotation().conjugate() * Eigen::Vector3d::UnitZ());
  const UncertainPose heeded = WithGravity({truth, 1e-8 * Matrix6::Identity()}, wrong_up, kSigma);
  EXPECT_LT(Difference(truth, heeded.map_from_camera).norm(), 1e-4);
}

TEST(Gravity, KeepsWhereThePoseLooks) {
  const Rigid3 level(Eigen::Quaterniond(Eigen::AngleAxisd(2, Eigen::Vector3d::UnitZ())), {3, 4, 5});
  const UncertainPose seen{level, Covariance(0.05)};
  const UncertainPose heeded = WithGravity(seen, Eigen::Vector3d::UnitZ(), kSigma);
  EXPECT_LT(Difference(level, heeded.map_from_camera).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(heeded.covariance(5, 5), seen.covariance(5, 5));
}

}  // namespace
}  // namespace waymark::localiser::internal
