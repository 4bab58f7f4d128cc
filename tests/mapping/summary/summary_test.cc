// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "mapping/io/submap_file.h"
#include "mapping/summary/summarise_map.h"
#include "tests/localiser/map_on_disk.h"
#include "tests/localiser/random_place.h"

namespace waymark::mapping {
namespace {

using localiser::MapOnDisk;
using localiser::RandomPlace;
using testing::Each;
using testing::Le;
using testing::SizeIs;

/// A place of which each landmark is seen by some of six images, in pixels where it would be.
SubmapModel MakeModel(int landmarks) {
  SubmapModel model = RandomPlace({.landmarks = landmarks, .sightings = 6}, 1).Model();
  std::erase_if(model.observations, [](const LandmarkObservation& seen) {
    return (seen.landmark * 7 + seen.image * 3) % 5 > 1 + seen.landmark % 4;
  });
  for (LandmarkObservation& seen : model.observations) {
    seen.x_px = static_cast<float>((seen.landmark * 37) % 640);
    seen.y_px = static_cast<float>((seen.landmark * 53 + seen.image) % 480);
  }
  return model;
}

TEST(LandmarkOrder, HoldsEverySeenLandmarkOnceWithSightingsOfItsOwn) {
  const SubmapModel model = MakeModel(400);
  const auto order = OrderLandmarks(model, {});
  std::set<std::uint32_t> seen, ordered;
  for (const LandmarkObservation& observation : model.observations) {
    seen.insert(observation.landmark);
  }
  for (const ChosenLandmark& chosen : order) {
    EXPECT_TRUE(ordered.insert(chosen.landmark).second);
    ASSERT_FALSE(chosen.observations.empty());
    for (const std::uint32_t index : chosen.observations) {
      EXPECT_EQ(model.observations[index].landmark, chosen.landmark);
    }
  }
  EXPECT_EQ(ordered, seen);
}

TEST(LandmarkOrder, LeavesNoImageOutForLong) {
  const SubmapModel model = MakeModel(600);
  const auto order = OrderLandmarks(model, {});
  std::vector<int> of_image(model.images.size());
  for (std::size_t i = 0; i < 60; ++i) {
    for (const LandmarkObservation& seen : model.observations) {
      of_image[seen.image] += seen.landmark == order[i].landmark;
    }
  }
  const auto [least, most] = std::ranges::minmax(of_image);
  EXPECT_GE(least, 15);
  EXPECT_LE(most, 3 * least);
}

TEST(LandmarkOrder, BeginsWithWhatManyImagesSee) {
  SubmapModel model = MakeModel(300);
  std::erase_if(model.observations, [](const LandmarkObservation& seen) {
    return seen.landmark != 123 && seen.image > 1;
  });
  EXPECT_EQ(OrderLandmarks(model, {}).front().landmark, 123U);
}

TEST(LandmarkOrder, OneLookNeedsOneDescriptorTwoLooksNeedTwo) {
  RandomPlace place(3);
  SubmapModel model = place.Model();
  model.landmarks.resize(2, Point<Submap>(Eigen::Vector3d::Zero()));
  model.observations.clear();
  const Descriptor day = place.RandomDescriptor(), night = place.RandomDescriptor();
  for (std::uint32_t image = 0; image < 3; ++image) {
    model.observations.push_back({0, image, 1, 1, day});
  }
  for (std::uint32_t image = 0; image < 3; ++image) {
    model.observations.push_back({1, image, 1, 1, image == 2 ? night : day});
  }
  for (const ChosenLandmark& chosen : OrderLandmarks(model, {})) {
    EXPECT_THAT(chosen.observations, SizeIs(chosen.landmark == 0 ? 1 : 2));
  }
}

TEST(Summary, FitsItsBytesAndKeepsImagesAndPlaces) {
  const SubmapModel model = MakeModel(3000);
  const std::size_t whole = EncodeSubmap(model)->size();
  const std::size_t most = OrderLandmarks(model, {}).size();  // others can only be left out
  for (const std::size_t max_bytes : {100'000UL, 300'000UL, 100'000'000UL}) {
    const SubmapModel summary = Summarise(model, {.max_bytes = max_bytes});
    const auto bytes = EncodeSubmap(summary);
    ASSERT_TRUE(bytes.ok()) << ToString(bytes.error());
    EXPECT_LE(bytes->size(), std::min(max_bytes, whole));
    EXPECT_GE(bytes->size(), std::min(max_bytes, whole / 2) - 5000);
    EXPECT_EQ(summary.images.size(), model.images.size());
    std::vector<int> descriptors(summary.landmarks.size());
    for (const LandmarkObservation& seen : summary.observations) ++descriptors[seen.landmark];
    EXPECT_THAT(descriptors, Each(testing::AllOf(testing::Ge(1), Le(3))));
    if (summary.landmarks.size() < most) {  // then no second descriptors, but for what is left over
      EXPECT_LE(summary.observations.size(), summary.landmarks.size() + 1);
    }
  }
}

TEST(Summary, OptionsThatCannotBeAreRefused) {
  EXPECT_FALSE(SummaryOptions{.max_bytes = 10}.Validate().ok());
  EXPECT_FALSE((SummaryOptions{.choice = {.grid = 0}}.Validate().ok()));
  EXPECT_TRUE(SummaryOptions{}.Validate().ok());
}

TEST(SummariseMap, MakesAMapOfItsOwnInTheSamePlace) {
  MapOnDisk disk;
  const Sim3 moved(1.01, Eigen::Quaterniond::Identity(), {5, 6, 7});
  disk.Add(MakeModel(3000), moved);
  disk.release().epoch = 4;
  ASSERT_TRUE(disk.map().StoreRelease(disk.release()).ok());
  const auto out = disk.map().folder().parent_path() / "small";
  const auto submaps =
      SummariseMap(disk.map(), disk.release(), out, {.max_bytes = 200'000}, {});
  ASSERT_TRUE(submaps.ok()) << ToString(submaps.error());
  ASSERT_THAT(*submaps, SizeIs(1));
  EXPECT_LT(submaps->front().landmarks_after, submaps->front().landmarks_before);
  const auto small = MapDirectory::Open(out);
  ASSERT_TRUE(small.ok());
  EXPECT_EQ(small->description().id, disk.map().description().id);
  const auto release = small->LoadCurrentRelease();
  ASSERT_TRUE(release.ok());
  EXPECT_EQ(release->epoch, 4U);
  EXPECT_EQ(release->submaps.front().id, submaps->front().after);
  EXPECT_EQ(release->submaps.front().map_from_submap.sim().translation(), moved.translation());
  EXPECT_EQ(SummariseMap(disk.map(), disk.release(), out, {}, {}).error().code,
            ErrorCode::kConflict);
}

}  // namespace
}  // namespace waymark::mapping
