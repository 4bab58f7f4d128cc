// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/renderer.h"

#include <gmock/gmock.h>

#include "examples/simulator/render/sensor.h"
#include "tests/examples/simulator/small_world.h"

namespace waymark::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

CameraModel TestCamera(Lens lens) {
  return *MakeCamera({.width_px = 160, .height_px = 120, .lens = lens});
}

/// The brightness-weighted centre of what is brighter than half.
Vector2d BrightCentre(const Radiance& image) {
  Vector2d sum = Vector2d::Zero();
  double weight = 0;
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      const double value =
          static_cast<double>(image.values[3 * static_cast<std::size_t>(y * image.width_px + x)]);
      sum += value * Vector2d(x + 0.5, y + 0.5);
      weight += value;
    }
  }
  return sum / weight;
}

TEST(Renderer, MeasuresTheDepthOfAFrontalPlaneExactly) {
  const City city = MakeBoard(Canvas(4, 4, {200, 200, 200, 0}), 7.25, 40);
  const Renderer renderer = *Renderer::Create(city, {}, EvenLight());
  const ViewRays rays(TestCamera(Lens::kPinhole));
  for (const double depth : renderer.RenderDepth(rays, LookEast()).depth_m) {
    ASSERT_NEAR(depth, 7.25, 1e-9);
  }
}

TEST(Renderer, MeasuresTheDepthOfASlantedPlaneAnalytically) {
  const City city = MakeBoard(Canvas(4, 4, {200, 200, 200, 0}), 7.25, 200);
  const Renderer renderer = *Renderer::Create(city, {}, EvenLight());
  const CameraModel camera = TestCamera(Lens::kDistorted);
  const ViewRays rays(camera);
  const Rigid3 pose(BodyFromCameraRotation(Angle::Degrees(31), Angle::Degrees(-12)),
                    Vector3d(0.5, -1, 2));
  const DepthImage image = renderer.RenderDepth(rays, pose);
  for (int y = 0; y < image.height_px; y += 7) {
    for (int x = 0; x < image.width_px; x += 7) {
      const Vector3d ray = pose.rotation() * camera.Unproject({x + 0.5, y + 0.5});
      const double along = (7.25 - 0.5) / ray.x();
      const double depth = along * camera.Unproject({x + 0.5, y + 0.5}).z();
      EXPECT_NEAR(image.depth_m[static_cast<std::size_t>(y * image.width_px + x)], depth, 1e-8);
    }
  }
}

TEST(Renderer, ShowsSkyAsDepthZero) {
  const City city = MakeBoard(Canvas(4, 4, {}), 5, 0.1);
  const Renderer renderer = *Renderer::Create(city, {}, EvenLight());
  const ViewRays rays(TestCamera(Lens::kPinhole));
  EXPECT_EQ(renderer.RenderDepth(rays, LookEast()).depth_m.front(), 0);
  EXPECT_FALSE(renderer.FindSurface({0, 0, 0}, {-1, 0, 0}).has_value());
}

TEST(Renderer, DrawsAPaintedPointWhereTheCameraModelProjectsIt) {
  constexpr double kDistance = 6;
  constexpr double kHalf = 4;
  for (const Lens lens : {Lens::kPinhole, Lens::kDistorted}) {
    const CameraModel camera = TestCamera(lens);
    const ViewRays rays(camera);
    for (const Vector2d& place : {Vector2d(0.5, 0.5), Vector2d(0.31, 0.62), Vector2d(0.7, 0.4)}) {
      Canvas canvas(800, 800, {});
      canvas.FillDisc(800 * place.x(), 800 * place.y(), 20, {255, 255, 255, 0});
      const City city = MakeBoard(canvas, kDistance, kHalf);
      const Renderer renderer = *Renderer::Create(city, {}, EvenLight());
      const Vector3d point(kDistance, kHalf - 2 * kHalf * place.x(), kHalf - 2 * kHalf * place.y());
      const auto expected = camera.Project(LookEast().Inverse() * point);
      ASSERT_TRUE(expected.has_value());
      EXPECT_LT((BrightCentre(renderer.Render(rays, LookEast())) - *expected).norm(), 0.05)
          << "expected " << expected->transpose();
    }
  }
}

TEST(Renderer, PutsTheShadowOfABoxBesideIt) {
  City city{{}, {}, {}, {}, {}, {}};
  city.textures.emplace_back(Canvas(4, 4, {200, 200, 200, 0}), TextureBorder::kClamp);
  city.mesh.AddQuad({-20, 20, 0}, {40, 0, 0}, {0, -40, 0}, {0, {}});
  Mesh box;
  box.AddBox({{0, 0, 0}, {1, 1, 2}, 0}, {0, {}});
  Lighting light = EvenLight();
  light.sky.setConstant(0.2F);
  light.sun.setConstant(0.8F);
  light.to_sun = Vector3d(-1, 0, 1).normalized();  // the shadow falls to the east, 2 m long
  const Renderer renderer = *Renderer::Create(city, box, light);
  const CameraModel camera = TestCamera(Lens::kPinhole);
  Eigen::Matrix3d looking_down;  // columns: right is east, down is south, forward is down
  looking_down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  const Rigid3 pose(Eigen::Quaterniond(looking_down), Vector3d(0, 0, 12));
  const Radiance image = renderer.Render(ViewRays(camera), pose);
  const auto brightness = [&](const Vector3d& point) {
    const Vector2d pixel = *camera.Project(pose.Inverse() * point);
    return image.values[3 * static_cast<std::size_t>(static_cast<int>(pixel.y()) * 160 +
                                                     static_cast<int>(pixel.x()))];
  };
  EXPECT_LT(brightness({1.5, 0, 0}), 0.7F * brightness({3.5, 0, 0}));
  EXPECT_NEAR(brightness({-1.5, 0, 0}), brightness({3.5, 0, 0}), 2);
  EXPECT_NEAR(brightness({1.5, 1.5, 0}), brightness({3.5, 0, 0}), 2);
}

TEST(Renderer, SmoothsEdgesTowardsFullSampling) {
  Canvas canvas(4, 4, {255, 255, 255, 0});
  const City city = MakeBoard(canvas, 6, 1.037);
  const Renderer renderer = *Renderer::Create(city, {}, EvenLight());
  const ViewRays rays(TestCamera(Lens::kPinhole));
  const Radiance edges = renderer.Render(rays, LookEast(), Antialiasing::kEdges);
  const Radiance full = renderer.Render(rays, LookEast(), Antialiasing::kFull);
  for (std::size_t i = 0; i < edges.values.size(); ++i) {
    ASSERT_NEAR(edges.values[i], full.values[i], 1);
  }
}

TEST(Sensor, AddsNoNoiseWhenAskedNotTo) {
  const Radiance flat{8, 8, std::vector<float>(192, 100.0F)};
  const ColourImage image =
      Expose(flat, EvenLight(), {.target_mean = 100, .noise_scale = 0}, Random(1));
  EXPECT_THAT(image.values, testing::Each(100));
}

TEST(Sensor, BrightensUpToItsLongestGain) {
  const Radiance dark{8, 8, std::vector<float>(192, 20.0F)};
  Lighting light = EvenLight();
  light.longest_gain = 3;
  const ColourImage image = Expose(dark, light, {.noise_scale = 0}, Random(1));
  EXPECT_THAT(image.values, testing::Each(60));
}

TEST(Sensor, NoiseIsSeededAndAsStrongAsStated) {
  const Radiance flat{64, 64, std::vector<float>(3 * 64 * 64, 128.0F)};
  Lighting light = EvenLight();
  light.noise = 5;
  const SensorOptions options{.target_mean = 128};
  const ColourImage a = Expose(flat, light, options, Random(1));
  EXPECT_EQ(a.values, Expose(flat, light, options, Random(1)).values);
  EXPECT_NE(a.values, Expose(flat, light, options, Random(2)).values);
  double squares = 0;
  for (const int value : a.values) squares += (value - 128) * (value - 128);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(a.values.size())), 5, 0.3);
}

}  // namespace
}  // namespace waymark::simulator
