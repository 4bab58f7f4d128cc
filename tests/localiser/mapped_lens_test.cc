// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/mapped_lens.h"

#include <gmock/gmock.h>

#include <cmath>
#include <vector>

namespace waymark::localiser::internal {
namespace {

CameraModel Pinhole(double focal_px = 700, double centre_x_px = 322) {
  return *CameraModel::Create(CameraKind::kPinhole, 640, 480,
                              std::vector{focal_px, focal_px, centre_x_px, 241.0});
}

/// What mapping makes of such a pinhole.
CameraModel Mapped(double focal_px, double k1) {
  return *CameraModel::Create(CameraKind::kOpenCv, 640, 480,
                              std::vector{focal_px, focal_px, 322.0, 241.0, k1, 0.0, 0.0, 0.0});
}

TEST(MappedLens, IsThatOfTheSameCamera) {
  const std::vector mapped{Pinhole(900), Mapped(690, 0.02)};
  EXPECT_EQ(MappedLens(Pinhole(), mapped), mapped[1]);
}

TEST(MappedLens, SeesThroughResizing) {
  const std::vector mapped{Mapped(690, 0.02)};
  const CameraModel stated =
      *CameraModel::Create(CameraKind::kPinhole, 320, 240, std::vector{350.0, 350.0, 161.0, 120.5});
  const CameraModel lens = MappedLens(stated, mapped);
  EXPECT_EQ(lens.width_px(), 320);
  EXPECT_EQ(lens.height_px(), 240);
  for (const Eigen::Vector3d& x : {Eigen::Vector3d(0.3, -0.2, 1), Eigen::Vector3d(-0.4, 0.3, 1)}) {
    EXPECT_LT((*lens.Project(x) - *mapped[0].Project(x) / 2).norm(), 1e-9);
  }
}

TEST(MappedLens, OddSidesAreResizedToRoundedOnes) {
  const std::vector mapped{
      *CameraModel::Create(CameraKind::kSimplePinhole, 641, 479, std::vector{690.0, 320.5, 239.5})};
  const CameraModel stated =
      *CameraModel::Create(CameraKind::kSimplePinhole, 214, 160, std::vector{234.0, 107.0, 80.0});
  EXPECT_NEAR(MappedLens(stated, mapped).FocalX(), 690 * std::sqrt(214.0 / 641 * 160 / 479), 1e-9);
}

TEST(MappedLens, ACutPictureIsAsStated) {
  const CameraModel stated =
      *CameraModel::Create(CameraKind::kPinhole, 640, 360, std::vector{700.0, 700.0, 322.0, 181.0});
  EXPECT_EQ(MappedLens(stated, std::vector{Mapped(690, 0.02)}), stated);
}

TEST(MappedLens, AnotherCameraIsAsStated) {
  for (const CameraModel& stated : {Pinhole(800), Pinhole(700, 320)}) {
    EXPECT_EQ(MappedLens(stated, std::vector{Mapped(690, 0.02)}), stated);
  }
  EXPECT_EQ(MappedLens(Pinhole(), {}), Pinhole());
}

TEST(MappedLens, AStatedDecentredLensIsNotAMappedPinhole) {
  const CameraModel stated = *CameraModel::Create(
      CameraKind::kOpenCv, 640, 480, std::vector{700.0, 700.0, 322.0, 241.0, 0.0, 0.0, 0.001, 0.0});
  EXPECT_EQ(MappedLens(stated, std::vector{Mapped(690, 0.02)}), stated);
}

}  // namespace
}  // namespace waymark::localiser::internal
