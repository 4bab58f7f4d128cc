// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/texture.h"

#include <gmock/gmock.h>

#include <cmath>

#include "examples/simulator/world/noise.h"

namespace waymark::simulator {
namespace {

Footprint Square(double u, double v, double size) {
  const auto s = static_cast<float>(size);
  return {{static_cast<float>(u), static_cast<float>(v)}, {s, 0}, {0, s}};
}

TEST(Texture, ShowsAPlainColourAtAnyFootprint) {
  const Texture texture(Canvas(100, 60, {200, 100, 50, 10}), TextureBorder::kClamp);
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    const Footprint footprint{{random.UniformFloat(-0.1, 1.1), random.UniformFloat(-0.1, 1.1)},
                              {random.UniformFloat(-0.3, 0.3), random.UniformFloat(-0.3, 0.3)},
                              {random.UniformFloat(-0.3, 0.3), random.UniformFloat(-0.3, 0.3)}};
    const Colour colour = texture.Sample(footprint);
    EXPECT_NEAR(colour[0], 200, 0.01);
    EXPECT_NEAR(colour[1], 100, 0.01);
    EXPECT_NEAR(colour[2], 50, 0.01);
    EXPECT_NEAR(colour[3], 10, 0.01);
  }
}

TEST(Texture, ReadsTheTexelUnderASmallFootprint) {
  Canvas canvas(8, 8, {});
  canvas.FillRectangle(5, 2, 6, 3, {240, 120, 60, 0});
  const Texture texture(canvas, TextureBorder::kClamp);
  const Colour colour = texture.Sample(Square(5.5 / 8, 2.5 / 8, 1e-4));
  EXPECT_NEAR(colour[0], 240, 1);
  EXPECT_NEAR(texture.Sample(Square(3.5 / 8, 2.5 / 8, 1e-4))[0], 0, 1);
}

TEST(Texture, InterpolatesBetweenTexelCentres) {
  Canvas canvas(2, 1, {});
  canvas.FillRectangle(1, 0, 2, 1, {200, 0, 0, 0});
  const Texture texture(canvas, TextureBorder::kClamp);
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const Colour colour = texture.Sample(Square(0.25 + 0.5 * share, 0.5, 1e-4));
    EXPECT_NEAR(colour[0], 200 * share, 1);
  }
}

TEST(Texture, AveragesWhatAPixelCannotResolve) {
  Canvas canvas(256, 256, {});
  for (int x = 0; x < 256; x += 2) canvas.FillRectangle(x, 0, x + 1, 256, {200, 200, 200, 0});
  const Texture texture(canvas, TextureBorder::kClamp);
  for (double at = 0.3; at < 0.7; at += 0.0137) {
    EXPECT_NEAR(texture.Sample(Square(at, 0.5, 8.0 / 256))[0], 100, 1);
  }
}

TEST(Texture, KeepsDetailAcrossAFlatAngle) {
  Canvas canvas(512, 512, {});  // stripes along u, seen with a footprint that is long in u
  for (int y = 0; y < 512; y += 16) canvas.FillRectangle(0, y, 512, y + 8, {200, 200, 200, 0});
  const Texture texture(canvas, TextureBorder::kClamp);
  const Footprint flat{{0.5F, 260.0F / 512}, {12.0F / 512, 0}, {0, 2.0F / 512}};
  EXPECT_GT(texture.Sample(flat)[0], 190);
}

TEST(Texture, RepeatsWhenAskedTo) {
  Canvas canvas(64, 64, {});
  canvas.FillRectangle(0, 0, 32, 64, {200, 0, 0, 0});
  const Texture texture(canvas, TextureBorder::kRepeat);
  EXPECT_NEAR(texture.Sample(Square(3.25, 7.5, 0.01))[0], 200, 1);
  EXPECT_NEAR(texture.Sample(Square(-1.25, 0.5, 0.01))[0], 0, 1);
}

TEST(Noise, HasTheStatedStrengthAndNoMean) {
  const auto field = MakeNoise(512, 512, {{6, 0.1F}}, 5);
  double sum = 0;
  double squares = 0;
  for (const float value : field) {
    sum += static_cast<double>(value);
    squares += static_cast<double>(value) * static_cast<double>(value);
  }
  const double count = static_cast<double>(field.size());
  EXPECT_NEAR(sum / count, 0, 0.01);
  EXPECT_NEAR(std::sqrt(squares / count), 0.1, 0.015);
}

TEST(Noise, IsTheSameForTheSameSeed) {
  EXPECT_EQ(MakeNoise(64, 32, {{3, 1}, {9, 1}}, 5), MakeNoise(64, 32, {{3, 1}, {9, 1}}, 5));
  EXPECT_NE(MakeNoise(64, 32, {{3, 1}, {9, 1}}, 5), MakeNoise(64, 32, {{3, 1}, {9, 1}}, 6));
}

TEST(Canvas, ClipsAtItsBorders) {
  Canvas canvas(20, 10, {});
  canvas.FillRectangle(-5, -5, 100, 100, {7, 7, 7, 0});
  canvas.FillDisc(0, 0, 30, {9, 9, 9, 0});
  canvas.DrawLine(-50, -50, 70, 40, 5, {11, 11, 11, 0});
  Random random(3);
  canvas.DrawWord(-4, -4, 30, 9, random, {13, 13, 13, 0});
  EXPECT_EQ(canvas.texels().size(), 200U);
}

}  // namespace
}  // namespace waymark::simulator
