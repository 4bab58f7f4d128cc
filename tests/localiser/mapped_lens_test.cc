// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/mapped_lens.h"

#include <gmock/gmock.h>

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
