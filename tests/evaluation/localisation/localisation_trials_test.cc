// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <numeric>

#include "tests/evaluation/localisation/conditions.h"
#include "tests/evaluation/localisation/false_accepts.h"
#include "tests/evaluation/localisation/picture_damage.h"
#include "tests/evaluation/running.h"

namespace waymark::evaluation {
namespace {

using simulator::LightPreset;

mapping::GrayImage Gradient() {
  mapping::GrayImage image{64, 48, {}};
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) image.pixels.push_back(static_cast<std::uint8_t>(3 * x + y / 4));
  }
  return image;
}

double Mean(const mapping::GrayImage& image) {
  return std::accumulate(image.pixels.begin(), image.pixels.end(), 0.0) /
         static_cast<double>(image.pixels.size());
}

TEST(PictureDamage, MirrorsBlursAndCovers) {
  const mapping::GrayImage image = Gradient();
  EXPECT_NE(Mirror(image).pixels, image.pixels);
  EXPECT_EQ(Mirror(Mirror(image)).pixels, image.pixels);
  EXPECT_NEAR(Mean(BlurOutOfFocus(image, 3)), Mean(image), 1);
  EXPECT_NEAR(Mean(BlurByMotion(image, 9)), Mean(image), 1);
  const mapping::GrayImage dark = Cover(image, 1, simulator::Random(1));
  EXPECT_LT(*std::max_element(dark.pixels.begin(), dark.pixels.end()), 90);
  const mapping::GrayImage half = Cover(image, 0.5, simulator::Random(1));
  int same = 0;
  for (std::size_t i = 0; i < half.pixels.size(); ++i) same += half.pixels[i] == image.pixels[i];
  EXPECT_NEAR(same, 64 * 48 / 2, 64 * 48 / 6);
}

TEST(Conditions, PhonesAreFoundInAMapOfTheSameLightAndAgainWithoutDrawing) {
  const ScratchFolder scratch(false);
  ConditionsPlan plan;
  MakeQuick(plan);
  plan.drives = plan.lights = {LightPreset::kDay};
  plan.rows = {1};
  plan.requests = 3;
  int drawn = 0;
  const Workshop workshop{
      scratch.path(), {}, [&](const std::string& what, std::size_t, std::size_t) {
        drawn += what.starts_with("drawing");
      }};
  const auto rows = RunConditions(plan, workshop);
  ASSERT_TRUE(rows.ok()) << ToString(rows.error());
  ASSERT_EQ(rows->size(), 1U);
  const Recall recall = Count(rows->front().verdicts);
  EXPECT_EQ(recall.requests, 3);
  EXPECT_GE(recall.within_25cm_2deg, 2);
  EXPECT_GT(drawn, 0);
  EXPECT_THAT(DescribeConditions(plan, *rows), testing::HasSubstr("Simulation"));
  EXPECT_THAT(EncodeConditions(plan, *rows), testing::HasSubstr("\"requests\": 3"));
  drawn = 0;
  plan.burst = 2;
  const auto in_bursts = RunConditions(plan, workshop);
  ASSERT_TRUE(in_bursts.ok()) << ToString(in_bursts.error());
  EXPECT_EQ(drawn, 0);
  EXPECT_GE(Count(in_bursts->front().verdicts).within_25cm_2deg, 2);
}

TEST(FalseAccepts, AnotherCityIsNotFound) {
  const ScratchFolder scratch(false);
  FalseAcceptsPlan plan;
  MakeQuick(plan);
  plan.only = "another city";
  plan.keyframes_per_walk = 2;
  const Workshop workshop{scratch.path(), {}, {}};
  const auto trials = PrepareFalseAccepts(plan, workshop);
  ASSERT_TRUE(trials.ok()) << ToString(trials.error());
  const auto verdicts = RunFalseAccepts(plan, *trials, workshop);
  ASSERT_TRUE(verdicts.ok()) << ToString(verdicts.error());
  EXPECT_GT(verdicts->size(), 10U);
  EXPECT_EQ(Count(*verdicts, "another city").accepted, 0);
  EXPECT_THAT(DescribeFalseAccepts(*trials, *verdicts), testing::HasSubstr("held"));
}

}  // namespace
}  // namespace waymark::evaluation
