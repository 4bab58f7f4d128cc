// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/rig_links.h"

#include <gmock/gmock.h>

namespace waymark::mapping {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

TaskInput EmptyInput() { return {.task = {.experience = ExperienceId("drive")}}; }

/// Adds an image of a camera that sits `aside_m` to the right of the rig.
void AddImage(TaskInput& input, const std::string& camera, int milliseconds, double aside_m) {
  IndexedImage image;
  image.time = FromNanoseconds<SensorTime>(std::int64_t{milliseconds} * 1000000);
  input.images.push_back(image);
  input.sequences.push_back("drive/" + camera);
  input.mounts.push_back(
      CameraMount{"drive/car", Rigid3(Eigen::Quaterniond::Identity(), {-aside_m, 0, 0})});
}

TEST(RigLinks, JoinAnImageWithTheOtherCameraAroundIt) {
  TaskInput input = EmptyInput();
  AddImage(input, "left", 0, -0.5);
  AddImage(input, "left", 200, -0.5);
  AddImage(input, "right", 50, 0.5);
  const auto links = LinkRigs(input);
  ASSERT_THAT(links, SizeIs(1));
  EXPECT_EQ(links[0].image, 2u);
  EXPECT_EQ(links[0].before, 0u);
  EXPECT_EQ(links[0].after, 1u);
  EXPECT_NEAR(links[0].share, 0.25, 1e-12);
  EXPECT_LT((links[0].offset_in_camera - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-12);
  EXPECT_GE(links[0].sigma_m, 0.005);
}

TEST(RigLinks, JoinEachOfEightCamerasWithAllOthers) {
  constexpr int kCameras = 8, kRounds = 4, kPeriodMs = 200;
  TaskInput input = EmptyInput();
  for (int round = 0; round < kRounds; ++round) {
    for (int k = 0; k < kCameras; ++k) {
      AddImage(input, std::to_string(k), kPeriodMs * round + 23 * k, 0.5 * k);
    }
  }
  // An image has another camera's around it unless that one fires later in the first round or
  // earlier in the last one.
  constexpr int kExpected = kCameras * (kCameras - 1) * (kRounds - 1);
  const auto links = LinkRigs(input);
  ASSERT_THAT(links, SizeIs(static_cast<std::size_t>(kExpected)));
  for (const RigLink& link : links) {
    const auto of = [&](std::uint32_t image) { return static_cast<int>(image) % kCameras; };
    EXPECT_EQ(of(link.before), of(link.after));
    EXPECT_EQ(link.after - link.before, static_cast<std::uint32_t>(kCameras));
    const int later = (of(link.image) - of(link.before) + kCameras) % kCameras;
    const double since_ms =
        of(link.image) > of(link.before) ? 23 * later : kPeriodMs - 23 * (kCameras - later);
    EXPECT_NEAR(link.share, since_ms / kPeriodMs, 1e-9);
    const double aside_m = 0.5 * (of(link.before) - of(link.image));
    EXPECT_LT((link.offset_in_camera - Eigen::Vector3d(aside_m, 0, 0)).norm(), 1e-12);
  }
}

TEST(RigLinks, BridgeNoLongPause) {
  TaskInput input = EmptyInput();
  AddImage(input, "left", 0, -0.5);
  AddImage(input, "left", 1500, -0.5);
  AddImage(input, "right", 50, 0.5);
  EXPECT_THAT(LinkRigs(input), IsEmpty());
}

TEST(RigLinks, AreLessCertainInTheMiddleOfALongerGap) {
  TaskInput input = EmptyInput();
  AddImage(input, "left", 0, -0.5);
  AddImage(input, "left", 400, -0.5);
  AddImage(input, "right", 10, 0.5);
  AddImage(input, "right", 200, 0.5);
  const auto links = LinkRigs(input);
  ASSERT_THAT(links, SizeIs(2));
  EXPECT_GT(links[1].sigma_m, 2 * links[0].sigma_m);
}

TEST(RigLinks, AreNoneWithoutARigOrBetweenRigs) {
  TaskInput input = EmptyInput();
  AddImage(input, "left", 0, -0.5);
  AddImage(input, "left", 200, -0.5);
  AddImage(input, "right", 50, 0.5);
  input.mounts[2]->rig = "other/car";
  EXPECT_THAT(LinkRigs(input), IsEmpty());
  input.mounts[2].reset();
  EXPECT_THAT(LinkRigs(input), IsEmpty());
}

}  // namespace
}  // namespace waymark::mapping
