// SPDX-License-Identifier: Apache-2.0
#include "localiser/localiser.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "tests/localiser/map_on_disk.h"
#include "tests/localiser/random_place.h"

namespace waymark::localiser {
namespace {

const Sim3 kMapFromSubmap(1.02, RotationFromVector({0, 0, 0.3}), {100, -40, 2});

class LocaliserTest : public testing::Test {
 protected:
  std::shared_ptr<const Localiser> Open() {
    const auto localiser = Localiser::Create(disk_.map(), disk_.release(), {});
    CHECK(localiser.ok(), "{}", ToString(localiser.error()));
    return *localiser;
  }
  LocalisationRequest Request(const Rigid3& place_from_camera, int clutter = 200) {
    return {place_.Photo(place_from_camera, clutter), TestCamera(), std::nullopt, std::nullopt};
  }

  RandomPlace place_{1};
  MapOnDisk disk_;
};

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

TEST_F(LocaliserTest, TheSubmapThatSeesMostWins) {
  disk_.Add(RandomPlace(2).Model());
  const SubmapId right = disk_.Add(place_.Model(), kMapFromSubmap);
  disk_.Add(RandomPlace(3).Model());
  const Localisation answer = Open()->Localise(Request(place_.Viewpoint(0)));
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  EXPECT_EQ(answer.pose->submap, right);
}

TEST_F(LocaliserTest, SubmapsThatOverlapAgree) {
  disk_.Add(place_.Model());
  disk_.Add(place_.Model());  // other sightings of the same landmarks
  EXPECT_TRUE(Open()->Localise(Request(place_.Viewpoint(0))).pose.has_value());
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
  request.prior = PositionPrior{Point<Map>(300, -40, 0), 50};
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

TEST_F(LocaliserTest, ASubmapUnderAnothersNameIsCorrupt) {
  const SubmapId a = disk_.Add(place_.Model());
  const SubmapId b = disk_.Add(RandomPlace(2).Model());
  std::filesystem::remove(disk_.map().SubmapPath(a));
  std::filesystem::copy_file(disk_.map().SubmapPath(b), disk_.map().SubmapPath(a));
  const auto localiser = Localiser::Create(disk_.map(), disk_.release(), {});
  ASSERT_FALSE(localiser.ok());
  EXPECT_EQ(localiser.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(localiser.error().message, testing::HasSubstr(a.text()));
}

TEST_F(LocaliserTest, AMissingOrDamagedSubmapIsNamed) {
  const SubmapId id = disk_.Add(place_.Model());
  const auto path = disk_.map().SubmapPath(id);
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(5000);
  file.put('x').put('y');
  file.close();
  const auto damaged = Localiser::Create(disk_.map(), disk_.release(), {});
  ASSERT_FALSE(damaged.ok());
  EXPECT_EQ(damaged.error().code, ErrorCode::kCorrupt);
  std::filesystem::remove(path);
  const auto missing = Localiser::Create(disk_.map(), disk_.release(), {});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, testing::HasSubstr(id.text()));
}

TEST_F(LocaliserTest, TheNextReleaseSharesWhatItKeepsAndPlacesItAnew) {
  const SubmapId kept = disk_.Add(place_.Model(), kMapFromSubmap);
  disk_.Add(RandomPlace(2).Model());
  const auto before = Open();
  const LocalisationRequest request = Request(place_.Viewpoint(2, -1));
  const Localisation was = before->Localise(request);
  ASSERT_TRUE(was.pose.has_value()) << was.reason;

  disk_.release().epoch = 2;
  std::erase_if(disk_.release().submaps,
                [&](const mapping::ReleasedSubmap& submap) { return submap.id != kept; });
  const Sim3 moved(1.02, RotationFromVector({0, 0, 0.3}), {103, -40, 2});
  disk_.release().submaps.front().map_from_submap = Similarity<Map, Submap>(moved);
  std::filesystem::remove(disk_.map().SubmapPath(kept));  // it is not read again
  const auto after = Localiser::Create(disk_.map(), disk_.release(), {}, before.get());
  ASSERT_TRUE(after.ok()) << ToString(after.error());
  const Localisation is = (*after)->Localise(request);
  ASSERT_TRUE(is.pose.has_value()) << is.reason;
  EXPECT_EQ(is.epoch, 2u);
  const Eigen::Vector3d shift =
      is.pose->map_from_camera.translation() - was.pose->map_from_camera.translation();
  EXPECT_LT((shift - Eigen::Vector3d(3, 0, 0)).norm(), 1e-9);
  EXPECT_EQ(before->Localise(request).epoch, was.epoch) << "both answer side by side";
}

TEST_F(LocaliserTest, AReleaseThatPlacesASubmapNowhereIsCorrupt) {
  disk_.Add(place_.Model(), Sim3(NAN, Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()));
  const auto localiser = Localiser::Create(disk_.map(), disk_.release(), {});
  ASSERT_FALSE(localiser.ok());
  EXPECT_EQ(localiser.error().code, ErrorCode::kCorrupt);
}

TEST(LocaliserOptions, NonsenseIsRefusedByName) {
  EXPECT_TRUE(LocaliserOptions{}.Validate().ok());
  LocaliserOptions options;
  options.max_ratio = 1.5;
  EXPECT_THAT(options.Validate().error().message, testing::HasSubstr("max_ratio"));
}

}  // namespace
}  // namespace waymark::localiser
