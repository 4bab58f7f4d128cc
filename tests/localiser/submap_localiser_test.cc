// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/submap_localiser.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <optional>

#include "localiser/internal/pose_acceptance.h"
#include "tests/localiser/random_place.h"

namespace waymark::localiser::internal {
namespace {

Eigen::Vector3d Up() { return Eigen::Vector3d::UnitZ(); }

const ImageSenses kSenses{TestCamera(), std::nullopt};

/// Owns what a SubmapLocaliser borrows.
struct Fixture {
  explicit Fixture(RandomPlace& place, const LocaliserOptions& options = {})
      : landmarks(place.landmarks()) {
    for (const auto& seen : place.Model().observations) {
      descriptors.push_back(seen.descriptor);
      observed.push_back(seen.landmark);
    }
    const std::array sets{std::span<const mapping::Descriptor>(descriptors)};
    quantiser.emplace(CoarseQuantiser::Train(sets, 16, 1));
    localiser.emplace(landmarks, descriptors, observed, *quantiser, options);
  }

  SubmapAnswer Localise(const mapping::ImageFeatures& photo) const {
    return localiser->Localise(photo, quantiser->Rank(photo.descriptors, 8), kSenses);
  }

  std::vector<Eigen::Vector3d> landmarks;
  std::vector<mapping::Descriptor> descriptors;
  std::vector<std::uint32_t> observed;
  std::optional<CoarseQuantiser> quantiser;
  std::optional<SubmapLocaliser> localiser;
};

TEST(SubmapLocaliser, FindsWhereAPhotoWasTakenAmongClutter) {
  RandomPlace place(1);
  const Fixture submap(place);
  for (const double east_m : {-6.0, 0.0, 5.0}) {
    const Rigid3 truth = place.Viewpoint(east_m, -2);
    const SubmapAnswer answer = submap.Localise(place.Photo(truth, 300));
    ASSERT_TRUE(answer.submap_from_camera.has_value()) << answer.refusal;
    const Rigid3& pose = answer.submap_from_camera->world_from_camera;
    EXPECT_LT((pose.translation() - truth.translation()).norm(), 0.05);
    EXPECT_LT(AngleBetween(pose.rotation(), truth.rotation()).degrees(), 0.3);
    EXPECT_GT(answer.submap_from_camera->inliers.size(), 100u);
  }
}

TEST(SubmapLocaliser, FindsTheSamePoseWithGravityThatIsOffByADegree) {
  RandomPlace place(1);
  const Fixture submap(place);
  for (const double east_m : {-6.0, 0.0, 5.0}) {
    const Rigid3 truth = place.Viewpoint(east_m, -2);
    const mapping::ImageFeatures photo = place.Photo(truth, 300);
    const Eigen::Quaterniond lean = RotationFromVector({0.02, -0.01, 0});
    const ImageSenses senses{
        TestCamera(), mapping::SharedUp{truth.rotation().conjugate() * (lean * Up()), Up()}};
    const SubmapAnswer without = submap.Localise(photo);
    const SubmapAnswer with = submap.localiser->Localise(
        photo, submap.quantiser->Rank(photo.descriptors, 8), senses);
    ASSERT_TRUE(with.submap_from_camera && without.submap_from_camera) << with.refusal;
    EXPECT_EQ(with.submap_from_camera->inliers, without.submap_from_camera->inliers);
    EXPECT_LT((with.submap_from_camera->world_from_camera.translation() -
               without.submap_from_camera->world_from_camera.translation())
                  .norm(),
              1e-3);
  }
}

TEST(SubmapLocaliser, RefusesACameraThatIsNotTheOneStated) {
  RandomPlace place(1);
  const Fixture submap(place, {.focal_sigma_share = 0.05});
  const mapping::ImageFeatures photo = place.Photo(place.Viewpoint(0), 100);
  const auto answer = [&](double factor) {
    return submap.localiser->Localise(photo, submap.quantiser->Rank(photo.descriptors, 8),
                                      {TestCamera().WithScaledFocal(factor), std::nullopt});
  };
  EXPECT_TRUE(answer(1.05).submap_from_camera.has_value());
  const SubmapAnswer refused = answer(1.3);
  EXPECT_FALSE(refused.submap_from_camera.has_value());
  EXPECT_THAT(refused.refusal, testing::HasSubstr("focal length"));
}

TEST(SubmapLocaliser, SaysWhenHousesAreCopies) {
  RandomPlace place(1);
  Fixture submap(place);
  const std::size_t own = submap.landmarks.size();
  const mapping::ImageFeatures photo = place.Photo(place.Viewpoint(0), 100);
  EXPECT_EQ(submap.localiser->FindAmbiguity(kSenses, submap.Localise(photo)), "");
  // A second house beside it; matching finds one half of it more similar, and one of the first.
  for (std::size_t i = 0; i < own; ++i) {
    submap.landmarks.push_back(submap.landmarks[i] + Eigen::Vector3d(40, 0, 0));
  }
  for (std::uint32_t& landmark : submap.observed) {
    if (landmark % 2 == 0) landmark += static_cast<std::uint32_t>(own);
  }
  submap.localiser.emplace(submap.landmarks, submap.descriptors, submap.observed, *submap.quantiser,
                           LocaliserOptions{});
  EXPECT_THAT(submap.localiser->FindAmbiguity(kSenses, submap.Localise(photo)),
              testing::HasSubstr("look alike"));
}

TEST(SubmapLocaliser, RefusesPhotosOfOtherPlaces) {
  RandomPlace place(1);
  const Fixture submap(place);
  for (std::uint64_t seed = 2; seed < 22; ++seed) {
    RandomPlace elsewhere(seed);
    const SubmapAnswer answer = submap.Localise(elsewhere.Photo(elsewhere.Viewpoint(0), 300));
    EXPECT_FALSE(answer.submap_from_camera.has_value()) << "seed " << seed;
    EXPECT_FALSE(answer.refusal.empty());
  }
}

TEST(SubmapLocaliser, RefusesMatchesThatAgreeOnNothing) {
  RandomPlace place(1);
  const Fixture submap(place);
  mapping::ImageFeatures shuffled = place.Photo(place.Viewpoint(0), 0);
  std::reverse(shuffled.descriptors.begin(), shuffled.descriptors.end());
  const SubmapAnswer answer = submap.Localise(shuffled);
  EXPECT_GT(answer.matches.size(), 100u);
  EXPECT_FALSE(answer.submap_from_camera.has_value());
}

TEST(SubmapLocaliser, FeaturesOfOnePlaceCountOnce) {
  RandomPlace place(1);
  const Fixture submap(place);
  mapping::ImageFeatures photo = place.Photo(place.Viewpoint(0), 0);
  const std::size_t once = submap.Localise(photo).matches.size();
  const mapping::ImageFeatures copy = photo;
  photo.keypoints.insert(photo.keypoints.end(), copy.keypoints.begin(), copy.keypoints.end());
  photo.descriptors.insert(photo.descriptors.end(), copy.descriptors.begin(),
                           copy.descriptors.end());
  EXPECT_EQ(submap.Localise(photo).matches.size(), once);
}

TEST(PoseAcceptance, ChanceExplainsFewInliersAmongManyMatchesButNotAmongFew) {
  const double chance = 0.002;
  EXPECT_GT(LogExpectedFalsePoses(1000, 15, chance), 0);
  EXPECT_LT(LogExpectedFalsePoses(40, 15, chance), -10);
  EXPECT_LT(LogExpectedFalsePoses(1000, 100, chance), -50);
}

TEST(PoseAcceptance, EachWayToBeWrongHasItsReason) {
  std::vector<Eigen::Vector2d> spread_px;
  std::vector<Eigen::Vector2d> crowded_px;
  for (int i = 0; i < 30; ++i) {
    spread_px.emplace_back(20 * i + 10, (i * 97) % 480);
    crowded_px.emplace_back(300 + i % 6, 200 + i / 6);
  }
  PoseEvidence evidence{.matches = 60,
                        .inliers_px = spread_px,
                        .position_covariance = Eigen::Matrix3d::Identity() * 1e-4,
                        .median_distance_m = 10,
                        .max_error_px = 6};
  EXPECT_EQ(FindReasonToRefuse(evidence, TestCamera()), std::nullopt);
  evidence.inliers_px = crowded_px;
  EXPECT_THAT(*FindReasonToRefuse(evidence, TestCamera()), testing::HasSubstr("parts"));
  evidence.inliers_px = spread_px;
  evidence.position_covariance(1, 1) = 4;
  EXPECT_THAT(*FindReasonToRefuse(evidence, TestCamera()), testing::HasSubstr("uncertain"));
  evidence.matches = 100000;
  EXPECT_THAT(*FindReasonToRefuse(evidence, TestCamera()), testing::HasSubstr("chance"));
}

}  // namespace
}  // namespace waymark::localiser::internal
