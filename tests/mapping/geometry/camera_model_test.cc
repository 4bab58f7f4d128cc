// SPDX-License-Identifier: Apache-2.0
#include "mapping/geometry/camera_model.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/random_geometry.h"

namespace waymark {
namespace {

std::vector<CameraModel> ExampleCameras() {
  const auto make = [](CameraKind kind, std::vector<double> parameters) {
    return CameraModel::Create(kind, 640, 480, parameters).value();
  };
  return {make(CameraKind::kSimplePinhole, {500, 320, 240}),
          make(CameraKind::kPinhole, {500, 510, 320, 240}),
          make(CameraKind::kSimpleRadial, {500, 320, 240, -0.1}),
          make(CameraKind::kRadial, {500, 320, 240, -0.1, 0.02}),
          make(CameraKind::kOpenCv, {500, 510, 320, 240, -0.1, 0.02, 0.001, -0.002})};
}

TEST(CameraModel, UnprojectUndoesProjectOverTheWholeImage) {
  for (const CameraModel& camera : ExampleCameras()) {
    for (double x = 0; x <= 640; x += 40) {
      for (double y = 0; y <= 480; y += 40) {
        const Eigen::Vector3d ray = camera.Unproject({x, y});
        EXPECT_NEAR(ray.norm(), 1, 1e-12);
        const auto pixel = camera.Project(3 * ray);
        ASSERT_TRUE(pixel);
        EXPECT_LT((*pixel - Eigen::Vector2d(x, y)).norm(), 1e-7) << CameraKindName(camera.kind());
      }
    }
  }
}

TEST(CameraModel, SeesNothingBehindIt) {
  for (const CameraModel& camera : ExampleCameras()) {
    EXPECT_FALSE(camera.Project({0, 0, -1}));
    EXPECT_FALSE(camera.Project({1, 0, 0}));
    EXPECT_FALSE(camera.Project({0, 0, std::numeric_limits<double>::quiet_NaN()}));
  }
}

TEST(CameraModel, TheAxisProjectsToThePrincipalPoint) {
  for (const CameraModel& camera : ExampleCameras()) {
    EXPECT_LT((*camera.Project({0, 0, 2}) - camera.PrincipalPoint()).norm(), 1e-12);
  }
}

TEST(CameraModel, NamesRoundTrip) {
  for (const CameraModel& camera : ExampleCameras()) {
    EXPECT_EQ(FindCameraKind(CameraKindName(camera.kind())), camera.kind());
  }
  EXPECT_FALSE(FindCameraKind("FISHEYE"));
}

TEST(CameraModel, RefusesWhatIsNoCamera) {
  const std::vector<double> good{500, 320, 240};
  EXPECT_TRUE(CameraModel::Create(CameraKind::kSimplePinhole, 640, 480, good));
  EXPECT_FALSE(CameraModel::Create(CameraKind::kSimplePinhole, 0, 480, good));
  EXPECT_FALSE(CameraModel::Create(CameraKind::kPinhole, 640, 480, good));
  for (const double focal : {0.0, -1.0, std::nan("")}) {
    EXPECT_FALSE(CameraModel::Create(CameraKind::kSimplePinhole, 640, 480,
                                     std::vector<double>{focal, 320, 240}));
  }
}

}  // namespace
}  // namespace waymark
