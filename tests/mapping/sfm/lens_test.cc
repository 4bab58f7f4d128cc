// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <array>
#include <cmath>

#include "mapping/sfm/incremental.h"
#include "mapping/synthetic/capture.h"
#include "mapping/synthetic/walk.h"

namespace waymark::mapping {
namespace {

constexpr double kFocal_px = 500;

CameraModel Pinhole() {
  const std::array parameters{kFocal_px, kFocal_px, 320.0, 240.0};
  return *CameraModel::Create(CameraKind::kPinhole, 640, 480, parameters);
}

/// What imperfect rectification leaves: up to 1.3 px in the corners.
CameraModel BentLens() {
  const std::array parameters{kFocal_px, 320.0, 240.0, 0.015, -0.009};
  return *CameraModel::Create(CameraKind::kRadial, 640, 480, parameters);
}

/// Forward and through a bend.
Capture Drive(const CameraModel& camera, int images) {
  std::vector<Rigid3> drive;
  for (int i = 0; i < images; ++i) {
    const double turned = 0.6 * i / images;
    drive.push_back(PlaceCamera({4 * (1 - std::cos(turned)), 1.0 * i, 1.7}, turned, 0));
  }
  return CaptureWalk(MakeStreet({.points = 1500}), camera, drive,
                     {.pixel_sigma_px = 0.3, .max_range_m = 35});
}

Result<Reconstruction> Reconstruct(const Capture& capture, const SfmCamera& stated) {
  return ReconstructIncrementally(std::array{stated}, capture.Images(),
                                  MatchCapture(capture, 30, {}), {.parallelism = {1}});
}

double MeanError_m(const Reconstruction& result, const Capture& capture) {
  std::vector<Eigen::Vector3d> from, to;
  for (std::size_t i = 0; i < result.images.size(); ++i) {
    if (!result.images[i].submap_from_camera) continue;
    from.push_back(result.images[i].submap_from_camera->translation());
    to.push_back(capture.world_from_camera[i].translation());
  }
  const auto align = EstimateSimilarity(from, to);
  double sum = align ? 0 : INFINITY;
  for (std::size_t i = 0; align && i < from.size(); ++i) sum += (*align * from[i] - to[i]).norm();
  return sum / static_cast<double>(from.size());
}

TEST(Lens, WhatAPinholeLeavesIsFound) {
  const Capture capture = Drive(BentLens(), 20);
  const auto result = Reconstruct(capture, {.model = Pinhole()});
  ASSERT_TRUE(result.ok()) << ToString(result.error());
  const CameraModel& found = result->cameras[0];
  ASSERT_EQ(found.kind(), CameraKind::kOpenCv);
  EXPECT_NEAR(found.FocalX(), kFocal_px, 3);
  EXPECT_NEAR(found.parameters()[4], 0.015, 0.005);
  EXPECT_LT(MeanError_m(*result, capture), 0.01);
  EXPECT_EQ(found.PrincipalPoint(), Pinhole().PrincipalPoint());
  EXPECT_EQ(found.parameters()[6], 0);  // tangential distortion
  EXPECT_EQ(found.parameters()[7], 0);
}

TEST(Lens, APinholeStaysOne) {
  const Capture capture = Drive(Pinhole(), 20);
  const auto result = Reconstruct(capture, {.model = Pinhole()});
  ASSERT_TRUE(result.ok()) << ToString(result.error());
  const CameraModel& found = result->cameras[0];
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(1, 1), Eigen::Vector2d(639, 240)}) {
    EXPECT_LT((*found.Project(Pinhole().Unproject(corner)) - corner).norm(), 0.7);
  }
  EXPECT_LT(MeanError_m(*result, capture), 0.01);
}

TEST(Lens, FewImagesOrAHeldCameraTellNothing) {
  const auto few = Drive(BentLens(), 9);
  const auto many = Drive(BentLens(), 12);
  const auto of_few = Reconstruct(few, {.model = Pinhole()});
  const auto held = Reconstruct(many, {.model = Pinhole(), .refine = false});
  ASSERT_TRUE(of_few.ok()) << ToString(of_few.error());
  ASSERT_TRUE(held.ok()) << ToString(held.error());
  EXPECT_EQ(of_few->cameras[0].kind(), CameraKind::kPinhole);
  EXPECT_EQ(held->cameras[0], Pinhole());
}

}  // namespace
}  // namespace waymark::mapping
