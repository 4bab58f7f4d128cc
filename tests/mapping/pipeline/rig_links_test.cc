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
