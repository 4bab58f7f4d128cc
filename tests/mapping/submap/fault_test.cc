// SPDX-License-Identifier: Apache-2.0
#include "mapping/synthetic/fault.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/mapping/submap/walk.h"

namespace waymark::mapping {
namespace {

Rigid3 PoseOf(const Reconstruction& found, std::size_t image) {
  const auto& pose = *found.images[image].submap_from_camera;
  return {pose.rotation(), pose.translation()};
}

/// Where a point is, seen from the first image that saw it: what no fault may change.
Eigen::Vector3d Seen(const Reconstruction& found, std::size_t point) {
  const ReconstructedPoint& one = found.points[point];
  return PoseOf(found, one.track.front().image).Inverse() * one.position.coordinates();
}

TEST(Fault, ABendTurnsTheEndByTheWholeAndKeepsSteps) {
  const Reconstruction before = MakeWalk(40);
  Reconstruction bent = before;
  Bend({.yaw_rad = 0.5}, bent);
  EXPECT_NEAR(AngleBetween(PoseOf(bent, 39).rotation(), PoseOf(before, 39).rotation()).radians(),
              0.5, 1e-9);
  for (std::size_t i = 1; i < 40; ++i) {
    EXPECT_NEAR((PoseOf(bent, i).translation() - PoseOf(bent, i - 1).translation()).norm(), 1,
                1e-9);
  }
  EXPECT_LT((Seen(bent, 7) - Seen(before, 7)).norm(), 1e-9);
  Reconstruction back = before;
  Bend({.pitch_rad = 0.5, .back = true}, back);
  EXPECT_NEAR(AngleBetween(PoseOf(back, 39).rotation(), PoseOf(before, 39).rotation()).radians(), 0,
              1e-9);
}

TEST(Fault, ScaleDriftsFromTheFirstStepToTheLast) {
  Reconstruction drifted = MakeWalk(40);
  DriftScale(3, drifted);
  const auto step = [&](std::size_t i) {
    return (PoseOf(drifted, i).translation() - PoseOf(drifted, i - 1).translation()).norm();
  };
  EXPECT_NEAR(step(1), 1, 0.03);
  EXPECT_NEAR(step(39), 3, 0.1);
}

TEST(Fault, AFoldPutsAnImageBackAlongTheWay) {
  const Reconstruction before = MakeWalk(40);
  Reconstruction folded = before;
  Fold(30, 10, folded);
  EXPECT_LT((PoseOf(folded, 30).translation() - PoseOf(before, 20).translation()).norm(), 1e-6);
  EXPECT_LT(AngleBetween(PoseOf(folded, 30).rotation(), PoseOf(before, 20).rotation()).radians(),
            1e-6);
  EXPECT_LT((PoseOf(folded, 29).translation() - PoseOf(before, 29).translation()).norm(), 1e-12);
}

TEST(Fault, AHingeTurnsAboutItsImage) {
  const Reconstruction before = MakeWalk(40);
  Reconstruction hinged = before;
  Hinge(20, 0.4, hinged);
  EXPECT_LT((PoseOf(hinged, 20).translation() - PoseOf(before, 20).translation()).norm(), 1e-12);
  EXPECT_NEAR(AngleBetween(PoseOf(hinged, 39).rotation(), PoseOf(before, 39).rotation()).radians(),
              0.4, 1e-9);
}

TEST(Fault, AMirroredWalkTurnsTheOtherWay) {
  const Reconstruction before = MakeWalk(40);
  Reconstruction mirrored = before;
  Mirror(mirrored);
  EXPECT_NEAR(PoseOf(mirrored, 3).rotation().toRotationMatrix().determinant(), 1, 1e-12);
  const auto turn = [](const Reconstruction& found) {
    return VectorFromRotation(PoseOf(found, 39).rotation() *
                              PoseOf(found, 0).rotation().conjugate());
  };
  EXPECT_LT((turn(before) + turn(mirrored)).norm(), 1e-9);
}

TEST(Fault, ToleratesImagesThatAreNotRegistered) {
  Reconstruction found = MakeWalk(40);
  for (auto& image : found.images) image.submap_from_camera.reset();
  found.points.clear();
  Bend({.yaw_rad = 1}, found);
  DriftScale(2, found);
  Fold(20, 3, found);
  Hinge(20, 1, found);
  Mirror(found);
  EXPECT_FALSE(found.images[3].submap_from_camera);
}

}  // namespace
}  // namespace waymark::mapping
