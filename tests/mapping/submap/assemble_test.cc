// SPDX-License-Identifier: Apache-2.0
#include "mapping/submap/assemble.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "tests/mapping/submap/walk.h"

namespace waymark::mapping {
namespace {

struct Input {
  Reconstruction found;
  ImageFeatures features;
  std::vector<AssemblyImage> images;
};

Input MakeInput(int image_count) {
  Input input{.found = MakeWalk(image_count), .features = {}, .images = {}};
  for (int p = 0; p < 200; ++p) {
    input.features.keypoints.push_back({static_cast<float>(p), 1, 2, 0});
    Descriptor descriptor{};
    descriptor[0] = static_cast<std::uint8_t>(p);
    input.features.descriptors.push_back(descriptor);
  }
  return input;
}

Result<SubmapModel> Assemble(Input& input, const AssemblyOptions& options = {}) {
  input.images.clear();
  for (std::size_t i = 0; i < input.found.images.size(); ++i) {
    input.images.push_back({.experience = ExperienceId("drive"),
                            .name = std::to_string(i),
                            .features = &input.features,
                            .gnss = std::nullopt,
                            .is_borrowed = i % 2 == 1});
  }
  return AssembleSubmap(input.found, input.images, GeoPoint{}, {}, options);
}

TEST(Assemble, KeepsRegisteredImagesAndTheirCameras) {
  Input input = MakeInput(10);
  input.found.images[4].submap_from_camera.reset();
  for (ReconstructedPoint& point : input.found.points) {
    std::erase_if(point.track, [](const TrackElement& e) { return e.image == 4; });
  }
  const auto model = Assemble(input);
  ASSERT_TRUE(model.ok()) << model.error().message;
  ASSERT_EQ(model->images.size(), 9u);
  EXPECT_EQ(model->images[4].name, "5");
  EXPECT_TRUE(model->images[4].is_borrowed);
  EXPECT_EQ(model->cameras.size(), 1u) << "camera 0 is used by none";
  EXPECT_EQ(model->images[0].camera, 0u);
}

TEST(Assemble, ObservationsAreSortedBoundedAndSpread) {
  Input input = MakeInput(60);
  const auto model = Assemble(input);
  ASSERT_TRUE(model.ok());
  EXPECT_EQ(model->landmarks.size(), 200u);
  EXPECT_EQ(model->observations.size(), 200u * 8);
  EXPECT_TRUE(std::ranges::is_sorted(model->observations, {}, [](const LandmarkObservation& o) {
    return std::tuple(o.landmark, o.image);
  }));
  for (std::size_t l = 0; l < 200; ++l) {
    EXPECT_LE(model->observations[8 * l].image, 2u);
    EXPECT_GE(model->observations[8 * l + 7].image, 57u);
    EXPECT_EQ(model->observations[8 * l].descriptor[0], l);
    EXPECT_EQ(model->observations[8 * l].x_px, static_cast<float>(l));
  }
}

TEST(Assemble, DropsShortTracksOnlyWhereEnoughRemain) {
  Input input = MakeInput(8);  // tracks of 2 and 3 images
  EXPECT_EQ(Assemble(input)->landmarks.size(), 200u);
  const std::size_t strong = Assemble(input, {.enough_landmarks = 100})->landmarks.size();
  EXPECT_GT(strong, 100u);
  EXPECT_LT(strong, 200u);
}

TEST(Assemble, RefusesWrongInput) {
  Input input = MakeInput(8);
  EXPECT_FALSE(Assemble(input, {.min_track = 1}).ok());
  input.found.points[0].track[0].feature = 200;
  EXPECT_EQ(Assemble(input).error().code, ErrorCode::kInvalidArgument);
  EXPECT_FALSE(AssembleSubmap(input.found, {}, GeoPoint{}, {}, {}).ok());
}

}  // namespace
}  // namespace waymark::mapping
