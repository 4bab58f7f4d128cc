// SPDX-License-Identifier: Apache-2.0
#include "mapping/geometry/rigid3.h"

#include <gmock/gmock.h>

#include "tests/support/random_geometry.h"

namespace waymark {
namespace {

using support::Near;
using support::RandomGeometry;

TEST(Rigid3, ObeysTheLawsOfAGroup) {
  RandomGeometry random(1);
  for (int i = 0; i < 200; ++i) {
    const Rigid3 a = random.Rigid(), b = random.Rigid(), c = random.Rigid();
    EXPECT_THAT(a * Rigid3(), Near(a));
    EXPECT_THAT(Rigid3() * a, Near(a));
    EXPECT_THAT(a * a.Inverse(), Near(Rigid3()));
    EXPECT_THAT((a * b) * c, Near(a * (b * c)));
    const Eigen::Vector3d x = random.Vector(10);
    EXPECT_LT(((a * b) * x - a * (b * x)).norm(), 1e-12 * 100);
  }
}

TEST(Rigid3, PerturbUndoesDifference) {
  RandomGeometry random(2);
  for (int i = 0; i < 200; ++i) {
    const Rigid3 a = random.Rigid(), b = random.Rigid();
    EXPECT_THAT(Perturb(a, Difference(a, b)), Near(b));
  }
}

TEST(Rigid3, RotationVectorsSurviveTinyAndHalfTurns) {
  for (const double angle : {0.0, 1e-12, 1e-8, 1e-4, 1.0, 3.141592}) {
    const Eigen::Vector3d vector = angle * Eigen::Vector3d(1, -2, 2) / 3;
    EXPECT_LT((VectorFromRotation(RotationFromVector(vector)) - vector).norm(), 1e-9) << angle;
  }
}

TEST(Rigid3, CrossMatrixIsTheCrossProduct) {
  RandomGeometry random(4);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d v = random.Vector(10), x = random.Vector(10);
    EXPECT_LT((CrossMatrix(v) * x - v.cross(x)).norm(), 1e-12);
  }
}

TEST(Rigid3, InterpolationMeetsItsEnds) {
  RandomGeometry random(3);
  const Rigid3 a = random.Rigid(), b = random.Rigid();
  EXPECT_THAT(Interpolate(a, b, 0), Near(a));
  EXPECT_THAT(Interpolate(a, b, 1), Near(b));
  const Rigid3 middle = Interpolate(a, b, 0.5);
  EXPECT_NEAR(AngleBetween(a.rotation(), middle.rotation()).radians(),
              AngleBetween(middle.rotation(), b.rotation()).radians(), 1e-9);
}

}  // namespace
}  // namespace waymark
