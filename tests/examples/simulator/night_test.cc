// SPDX-License-Identifier: Apache-2.0
// What makes pictures at night hard: pools of light, open shutters, noise and what is done about
// it.
#include <gtest/gtest.h>

#include <cmath>

#include "examples/simulator/render/denoise.h"
#include "examples/simulator/render/exposure.h"
#include "examples/simulator/render/sensor.h"
#include "tests/examples/simulator/small_view.h"

namespace waymark::simulator {
namespace {

using Eigen::Vector3d;

/// White to the left of the middle, black to its right, 10 m away.
City MakeStep() {
  Canvas canvas(512, 8, {0, 0, 0, 0});
  canvas.FillRectangle(0, 0, 256, 8, {250, 250, 250, 0});
  return MakeBoard(canvas, 10, 12);
}

/// How many pixels of a row are neither black nor white.
int GreyPixels(const Radiance& image) {
  int grey = 0;
  for (int column = 0; column < kWidth; ++column) {
    const float red = RedAt(image, column, kHeight / 2);
    grey += red > 20 && red < 150 ? 1 : 0;
  }
  return grey;
}

TEST(StreetLamps, LightWhatIsNearAndNotBehindSomething) {
  City city = MakeBoard(Canvas(4, 4, {250, 250, 250, 0}), 10, 12);
  city.lamps = {{7, 4, 0}};
  Lighting dark = EvenLight();
  dark.sky.setZero();
  dark.lamp.setConstant(2);
  const Radiance lit = Renderer::Create(city, {}, dark)->Render(TestRays(), LookEast());
  EXPECT_GT(RedAt(lit, 31, 60), 4 * RedAt(lit, 150, 60));  // 4 m to the left, far to the right
  // At 3 m and head on: 2 / 9 of white.
  EXPECT_NEAR(RedAt(lit, 31, 60), 250 * std::pow(2 / 9.0, 1 / 2.2), 8);

  city.mesh.AddQuad({8, 6, 2}, {0, -4, 0}, {0, 0, -4}, {0, {}});
  const Radiance hidden = Renderer::Create(city, {}, dark)->Render(TestRays(), LookEast());
  EXPECT_LT(RedAt(hidden, 52, 60), 0.5F * RedAt(lit, 52, 60));
}

TEST(Exposure, DrawsOutWhatMovesByAsMuchAsItMoves) {
  const City city = MakeStep();
  Lighting light = EvenLight();
  light.exposure_s = 0.05;
  const auto renderer = Renderer::Create(city, {}, light);
  const auto draw = [&](const CameraMotion& motion) {
    return RenderExposure(*renderer, TestRays(), LookEast(), motion);
  };
  EXPECT_LE(GreyPixels(draw({})), 2);
  // 126 px a radian: 6.3 px within the exposure.
  const CameraMotion turning{.turning_radps = {0, 1, 0}};
  EXPECT_NEAR(GreyPixels(draw(turning)), 6, 2);
  // 10 m away, 5 m/s sideways: 3.1 px.
  const CameraMotion passing{.velocity_mps = {0, 5, 0}};
  EXPECT_NEAR(GreyPixels(draw(passing)), 3, 1);
  CameraMotion fast = turning;
  fast.shutter = 0.1;
  EXPECT_LE(GreyPixels(draw(fast)), 2);
}

TEST(Exposure, IsOneLookWhereNothingMoves) {
  const City city = MakeStep();
  const auto renderer = Renderer::Create(city, {}, MakeLighting(LightPreset::kNight, Random(1)));
  EXPECT_EQ(RenderExposure(*renderer, TestRays(), LookEast(), {}).values,
            renderer->Render(TestRays(), LookEast()).values);
}

TEST(Denoise, LessensNoiseAndKeepsEdges) {
  Radiance step{64, 64, {}};
  for (int i = 0; i < 64 * 64; ++i) {
    step.values.insert(step.values.end(), 3, i % 64 < 32 ? 60.0F : 200.0F);
  }
  Lighting light = EvenLight();
  light.noise = 4.5F;  // below what is smoothed by itself
  const ColourImage noisy = Expose(step, light, {.target_mean = 130}, Random(1));
  const ColourImage smooth = Denoise(noisy, light.noise);
  double before = 0, after = 0;
  for (int row = 0; row < 64; ++row) {
    for (int column = 0; column < 64; ++column) {
      const auto at = 3 * static_cast<std::size_t>(64 * row + column);
      const double truth = column < 32 ? 60 : 200;
      before += std::pow(noisy.values[at] - truth, 2);
      after += std::pow(smooth.values[at] - truth, 2);
    }
  }
  EXPECT_LT(after, before / 4);
}

}  // namespace
}  // namespace waymark::simulator
