// SPDX-License-Identifier: Apache-2.0
#include "localiser/localiser.h"

#include <gmock/gmock.h>

#include <thread>

#include "tests/localiser/localiser_fixture.h"

namespace waymark::localiser {
namespace {

TEST_F(LocaliserTest, AnswersInTheMapAndInTheSubmapWithMatchingCovariance) {
  const SubmapId id = disk_.Add(place_.Model(), kMapFromSubmap);
  disk_.release().epoch = 7;
  const Rigid3 truth = place_.Viewpoint(2, -1);
  const Localisation answer = Open()->Localise(Request(truth));
  ASSERT_EQ(answer.status, LocalisationStatus::kLocalised) << answer.reason;
  EXPECT_EQ(answer.epoch, 7u);
  EXPECT_EQ(answer.pose->submap, id);
  const Rigid3 expected = CarryPose(kMapFromSubmap, truth);
  EXPECT_LT((answer.pose->map_from_camera.translation() - expected.translation()).norm(), 0.05);
  EXPECT_LT(AngleBetween(answer.pose->map_from_camera.rotation(), expected.rotation()).degrees(),
            0.3);
  EXPECT_LT((answer.pose->submap_from_camera.translation() - truth.translation()).norm(), 0.05);
  const Eigen::Matrix<double, 6, 1> error =
      Difference(answer.pose->map_from_camera.rigid(), expected);
  EXPECT_LT(error.dot(answer.pose->covariance.inverse() * error), 40) << "a few sigmas";
  EXPECT_GT(answer.times.total_ms, 0);
}

TEST_F(LocaliserTest, NamesTheExperienceThatShowsMostOfWhatWasFound) {
  mapping::SubmapModel model = place_.Model();  // three images, each shows everything
  model.images[0].experience = ExperienceId("day");
  model.images[1].experience = ExperienceId("night");
  model.images[2].experience = ExperienceId("day");
  std::erase_if(model.observations, [](const mapping::LandmarkObservation& seen) {
    const std::uint32_t sixth = seen.landmark % 6;  // day alone saw one, night two, both three
    return seen.image == 1 ? sixth == 0 : sixth == 2 || sixth == 4;
  });
  disk_.Add(model, kMapFromSubmap);
  const Localisation answer = Open()->Localise(Request(place_.Viewpoint(0)));
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  // What day saw twice counts once; by sightings it would have most.
  EXPECT_EQ(answer.pose->experience, ExperienceId("night"));
}

TEST_F(LocaliserTest, TheSubmapThatSeesMostWins) {
  disk_.Add(RandomPlace(2).Model());
  const SubmapId right = disk_.Add(place_.Model(), kMapFromSubmap);
  disk_.Add(RandomPlace(3).Model());
  const Localisation answer = Open()->Localise(Request(place_.Viewpoint(0)));
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  EXPECT_EQ(answer.pose->submap, right);
}

TEST_F(LocaliserTest, KdTreesFindThePlaceToo) {
  disk_.Add(place_.Model(), kMapFromSubmap);
  const auto localiser = Open({.search = SearchMethod::kKdTrees});
  EXPECT_TRUE(localiser->Localise(Request(place_.Viewpoint(0))).pose.has_value());
  EXPECT_GT(localiser->memory().resident_bytes, 0u);
}

TEST_F(LocaliserTest, SubmapsThatOverlapAgree) {
  disk_.Add(place_.Model());
  disk_.Add(place_.Model());  // other sightings of the same landmarks
  EXPECT_TRUE(Open()->Localise(Request(place_.Viewpoint(0))).pose.has_value());
}

/// Every other landmark of a place, which two submaps know half each.
mapping::SubmapModel HalfOf(const mapping::SubmapModel& whole, std::uint32_t parity,
                            const Sim3& half_from_whole) {
  mapping::SubmapModel half = whole;
  half.landmarks.clear();
  half.observations.clear();
  for (std::uint32_t i = parity; i < whole.landmarks.size(); i += 2) {
    half.landmarks.emplace_back(half_from_whole * whole.landmarks[i].coordinates());
  }
  for (mapping::LandmarkObservation seen : whole.observations) {
    if (seen.landmark % 2 != parity) continue;
    seen.landmark /= 2;
    half.observations.push_back(seen);
  }
  return half;
}

TEST_F(LocaliserTest, SubmapsThatShowTooLittleEachAnswerTogether) {
  place_ = RandomPlace({.landmarks = 36}, 5);
  const mapping::SubmapModel whole = place_.Model();
  const Sim3 elsewhere(0.5, RotationFromVector({0, 0, 1}), {3, 4, 1});  // a frame of its own
  const SubmapId even = disk_.Add(HalfOf(whole, 0, Sim3()), kMapFromSubmap);
  const SubmapId odd = disk_.Add(HalfOf(whole, 1, elsewhere), kMapFromSubmap * elsewhere.Inverse());
  const Rigid3 truth = place_.Viewpoint(1);
  const Localisation answer = Open()->Localise(Request(truth));
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  EXPECT_GT(answer.pose->inliers, 18) << "of at most 18 landmarks each";
  EXPECT_THAT(answer.reason, testing::HasSubstr("with what others show"));
  EXPECT_THAT(answer.pose->submap, testing::AnyOf(even, odd));
  const Rigid3 expected = CarryPose(kMapFromSubmap, truth);
  EXPECT_LT((answer.pose->map_from_camera.translation() - expected.translation()).norm(), 0.1);
  const Sim3& home =
      answer.pose->submap == even ? kMapFromSubmap : kMapFromSubmap * elsewhere.Inverse();
  EXPECT_LT((CarryPose(home, answer.pose->submap_from_camera.rigid()).translation() -
             answer.pose->map_from_camera.translation())
                .norm(),
            1e-6);
  EXPECT_EQ(answer.pose->experience, ExperienceId("drive"));
}

TEST_F(LocaliserTest, SubmapsThatContradictEachOtherDoNotAnswerTogether) {
  place_ = RandomPlace({.landmarks = 36}, 5);
  const mapping::SubmapModel whole = place_.Model();
  disk_.Add(HalfOf(whole, 0, Sim3()), kMapFromSubmap);
  disk_.Add(HalfOf(whole, 1, Sim3()),
            Sim3(1, Eigen::Quaterniond::Identity(), {0, 0, 5}) * kMapFromSubmap);
  const Localisation answer = Open()->Localise(Request(place_.Viewpoint(1)));
  EXPECT_FALSE(answer.pose.has_value()) << answer.reason;
}

TEST_F(LocaliserTest, OnlySubmapsNearThePriorAreSearched) {
  disk_.Add(place_.Model(), kMapFromSubmap);
  const auto localiser = Open();
  LocalisationRequest request = Request(place_.Viewpoint(0));
  request.prior = PositionPrior{Point<Map>(105, -35, 50), 50};
  EXPECT_EQ(localiser->Localise(request).status, LocalisationStatus::kLocalised);
  request.prior = PositionPrior{Point<Map>(300, -40, 0), 50};
  const Localisation far = localiser->Localise(request);
  EXPECT_EQ(far.status, LocalisationStatus::kNothingNear);
  EXPECT_THAT(far.reason, testing::HasSubstr("50 m"));
}

TEST_F(LocaliserTest, APoseFarFromThePriorIsRefused) {
  disk_.Add(place_.Model(), kMapFromSubmap, 500);
  LocalisationRequest request = Request(place_.Viewpoint(0));
  request.prior = PositionPrior{Point<Map>(155, -40, 0), 50};
  const Localisation answer = Open()->Localise(request);
  EXPECT_EQ(answer.status, LocalisationStatus::kNoConsistentPose);
  EXPECT_THAT(answer.reason, testing::HasSubstr("prior"));
}

TEST_F(LocaliserTest, GravityConfirmsOrContradicts) {
  disk_.Add(place_.Model(), kMapFromSubmap);
  const auto localiser = Open();
  LocalisationRequest request = Request(place_.Viewpoint(0));
  request.up_in_camera = Eigen::Vector3d(0, -1, 0);
  EXPECT_EQ(localiser->Localise(request).status, LocalisationStatus::kLocalised);
  request.up_in_camera = Eigen::Vector3d(std::sin(0.3), -std::cos(0.3), 0);
  const Localisation answer = localiser->Localise(request);
  EXPECT_EQ(answer.status, LocalisationStatus::kNoConsistentPose);
  EXPECT_THAT(answer.reason, testing::HasSubstr("gravity"));
}

TEST_F(LocaliserTest, TwoPlacesThatLookAlikeAreNoAnswer) {
  disk_.Add(place_.Model());
  disk_.Add(place_.Model(), Sim3(1, Eigen::Quaterniond::Identity(), {80, 0, 0}));
  const auto localiser = Open();
  LocalisationRequest request = Request(place_.Viewpoint(0));
  const Localisation answer = localiser->Localise(request);
  EXPECT_EQ(answer.status, LocalisationStatus::kNoConsistentPose);
  EXPECT_THAT(answer.reason, testing::HasSubstr("look alike"));
  request.prior = PositionPrior{Point<Map>(80, 0, 0), 20};
  const Localisation told = localiser->Localise(request);
  ASSERT_TRUE(told.pose.has_value()) << told.reason;
  EXPECT_NEAR(told.pose->map_from_camera.translation().x(), 80, 0.1);
}

TEST_F(LocaliserTest, EachRefusalHasItsStatusAndFigures) {
  disk_.Add(place_.Model());
  const auto localiser = Open();
  LocalisationRequest request = Request(place_.Viewpoint(0));
  request.image = mapping::ImageFeatures{};
  EXPECT_EQ(localiser->Localise(request).status, LocalisationStatus::kTooFewFeatures);
  RandomPlace elsewhere(9);
  request.image = elsewhere.Photo(elsewhere.Viewpoint(0), 100);
  const Localisation unknown = localiser->Localise(request);
  EXPECT_EQ(unknown.status, LocalisationStatus::kTooFewMatches);
  EXPECT_THAT(unknown.reason, testing::HasSubstr("matches"));
  EXPECT_FALSE(unknown.pose.has_value());
}

TEST_F(LocaliserTest, ARequestThatContradictsItselfIsSaidToBeInvalid) {
  disk_.Add(place_.Model());
  const auto localiser = Open();
  const LocalisationRequest good = Request(place_.Viewpoint(0));
  LocalisationRequest request = good;
  request.image = mapping::GrayImage{10, 10, std::vector<std::uint8_t>(100)};
  EXPECT_EQ(localiser->Localise(request).status, LocalisationStatus::kInvalidRequest);
  request = good;
  std::get<mapping::ImageFeatures>(request.image).descriptors.pop_back();
  EXPECT_EQ(localiser->Localise(request).status, LocalisationStatus::kInvalidRequest);
  request = good;
  std::get<mapping::ImageFeatures>(request.image).keypoints[0].x_px = NAN;
  EXPECT_EQ(localiser->Localise(request).status, LocalisationStatus::kInvalidRequest);
  request = good;
  request.up_in_camera = Eigen::Vector3d::Zero();
  EXPECT_EQ(localiser->Localise(request).status, LocalisationStatus::kInvalidRequest);
  request = good;
  request.prior = PositionPrior{Point<Map>(NAN, 0, 0), 50};
  EXPECT_EQ(localiser->Localise(request).status, LocalisationStatus::kInvalidRequest);
}

TEST_F(LocaliserTest, AnEmptyReleaseLocalisesNothing) {
  const Localisation answer = Open()->Localise(Request(place_.Viewpoint(0)));
  EXPECT_EQ(answer.status, LocalisationStatus::kNothingNear);
}

TEST_F(LocaliserTest, ManyThreadsGetTheSameAnswerBitForBit) {
  disk_.Add(place_.Model(), kMapFromSubmap);
  disk_.Add(RandomPlace(2).Model());
  const LocalisationRequest request = Request(place_.Viewpoint(1));
  const auto localiser = Open();
  const auto reopened = Open();
  const Localisation expected = localiser->Localise(request);
  ASSERT_TRUE(expected.pose.has_value());
  std::vector<Localisation> answers(16);
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&, t] {
        const auto& asked = t % 2 == 0 ? localiser : reopened;
        for (int i = 0; i < 4; ++i) answers[4 * t + i] = asked->Localise(request);
      });
    }
  }
  for (const Localisation& answer : answers) {
    ASSERT_TRUE(answer.pose.has_value());
    EXPECT_EQ(answer.pose->map_from_camera.translation(),
              expected.pose->map_from_camera.translation());
    EXPECT_EQ(answer.pose->map_from_camera.rotation().coeffs(),
              expected.pose->map_from_camera.rotation().coeffs());
    EXPECT_EQ(answer.pose->covariance, expected.pose->covariance);
    EXPECT_EQ(answer.pose->inliers, expected.pose->inliers);
  }
}

TEST(LocaliserOptions, NonsenseIsRefusedByName) {
  EXPECT_TRUE(LocaliserOptions{}.Validate().ok());
  LocaliserOptions options;
  options.max_ratio = 1.5;
  EXPECT_THAT(options.Validate().error().message, testing::HasSubstr("max_ratio"));
}

}  // namespace
}  // namespace waymark::localiser
