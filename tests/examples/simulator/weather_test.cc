// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "examples/simulator/render/rain.h"
#include "tests/examples/simulator/small_view.h"

namespace waymark::simulator {
namespace {

using Eigen::Vector3d;

float Contrast(const Radiance& image) {
  const auto [low, high] = std::minmax_element(image.values.begin(), image.values.end());
  return *high - *low;
}

/// Dark ground, and a wall 10 m to the east that is white as far as the eye's height.
City MakeGroundAndWall() {
  City city{{}, {}, {}, {}, {}, {}};
  city.textures.emplace_back(Canvas(4, 4, {60, 60, 60, 0}), TextureBorder::kClamp);
  city.textures.emplace_back(Canvas(4, 4, {250, 250, 250, 0}), TextureBorder::kClamp);
  city.mesh.AddQuad({-30, 30, 0}, {60, 0, 0}, {0, -60, 0}, {0, {}});
  city.mesh.AddQuad({10, 30, 1.6}, {0, -60, 0}, {0, 0, -1.6}, {1, {}});
  return city;
}

Rigid3 EyeHighLookEast() { return {LookEast().rotation(), Vector3d(0, 0, 1.6)}; }

TEST(Lighting, PresetsAreFoundByTheirNames) {
  for (const LightPreset preset :
       {LightPreset::kDay, LightPreset::kOvercast, LightPreset::kRain, LightPreset::kEvening,
        LightPreset::kNight, LightPreset::kLowSunBehind, LightPreset::kLowSunAgainst}) {
    EXPECT_EQ(FindLightPreset(LightPresetName(preset)), preset);
    EXPECT_THAT(LightPresetNames(), testing::HasSubstr(std::string(LightPresetName(preset))));
    EXPECT_NEAR(MakeLighting(preset, Random(1)).to_sun.norm(), 1, 1e-12);
  }
  EXPECT_EQ(FindLightPreset("noon"), std::nullopt);
}

TEST(Renderer, WetGroundIsDarkerAndMirrorsWhatStandsOnIt) {
  const City city = MakeGroundAndWall();
  Lighting light = EvenLight();
  light.sky.setConstant(0.5F);
  const Radiance dry = Renderer::Create(city, {}, light)->Render(TestRays(), EyeHighLookEast());
  light.wetness = 1;
  const Radiance wet = Renderer::Create(city, {}, light)->Render(TestRays(), EyeHighLookEast());
  EXPECT_LT(RedAt(wet, 80, kHeight - 1), 0.9F * RedAt(dry, 80, kHeight - 1));
  EXPECT_GT(RedAt(wet, 80, 81), 1.2F * RedAt(dry, 80, 81));  // just before the foot of the wall
  EXPECT_EQ(RedAt(wet, 80, 70), RedAt(dry, 80, 70));         // the wall itself
}

TEST(Renderer, HazeDrawsWhatIsFarTowardsTheHorizonsColour) {
  const City city = MakeBoard(Canvas(4, 4, {0, 0, 0, 0}), 20, 40);
  Lighting light = EvenLight();
  light.horizon = {200, 200, 200};
  light.haze_per_m = 0.05F;
  const Radiance image = Renderer::Create(city, {}, light)->Render(TestRays(), LookEast());
  EXPECT_NEAR(RedAt(image, 80, 60), 200 * (1 - std::exp(-1.0)), 1);
}

TEST(Renderer, ASunBeforeTheLensVeilsTheImageUnlessSomethingStandsInBetween) {
  Canvas squares(64, 64, {30, 30, 30, 0});
  squares.FillDisc(32, 32, 12, {220, 220, 220, 0});
  const City city = MakeBoard(squares, 6, 3);
  Lighting light = EvenLight();
  light.sun.setConstant(0.8F);
  light.to_sun = Vector3d(1, 0, 0.7).normalized();  // over the board's upper edge
  const Radiance clear = Renderer::Create(city, {}, light)->Render(TestRays(), LookEast());
  light.glare = 1;
  const Radiance veiled = Renderer::Create(city, {}, light)->Render(TestRays(), LookEast());
  EXPECT_GT(RedAt(veiled, 80, 10), RedAt(clear, 80, 10) + 10);
  light.to_sun = Vector3d(1, 0, 0.2).normalized();  // behind the board
  const Radiance hidden = Renderer::Create(city, {}, light)->Render(TestRays(), LookEast());
  light.glare = 0;
  EXPECT_EQ(hidden.values,
            Renderer::Create(city, {}, light)->Render(TestRays(), LookEast()).values);
}

TEST(Rain, IsSeededAndLeavesADryDayAlone) {
  const Radiance flat{kWidth, kHeight, std::vector<float>(3 * kWidth * kHeight, 100.0F)};
  Radiance dry = flat;
  AddRain(0, Random(1), dry);
  EXPECT_EQ(dry.values, flat.values);
  Radiance a = flat, b = flat, c = flat;
  AddRain(1, Random(1), a);
  AddRain(1, Random(1), b);
  AddRain(1, Random(2), c);
  EXPECT_EQ(a.values, b.values);
  EXPECT_NE(a.values, c.values);
  EXPECT_GT(Contrast(a), 3);
}

}  // namespace
}  // namespace waymark::simulator
