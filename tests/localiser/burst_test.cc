// SPDX-License-Identifier: Apache-2.0
// Several images and the odometry between them, asked as one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/localiser/localiser_fixture.h"

namespace waymark::localiser {
namespace {

using testing::HasSubstr;

constexpr double kStepM = 0.8;  // between two images, of the place

class BurstTest : public LocaliserTest {
 protected:
  BurstTest() { disk_.Add(place_.Model(), kMapFromSubmap); }

  /// A frame that odometry started in: level, turned and far away.
  Transform<Vo, Camera> InOdometry(const Rigid3& place_from_camera, double scale = 1) const {
    const Rigid3 vo_from_map(RotationFromVector({0, 0, 2.1}), {-300, 70, 12});
    const Rigid3 vo_from_camera = vo_from_map * CarryPose(kMapFromSubmap, place_from_camera);
    return {vo_from_camera.rotation(), scale * vo_from_camera.translation()};
  }

  /// So many landmarks of what is seen, others in every image, and clutter.
  mapping::ImageFeatures Starved(const Rigid3& place_from_camera, std::size_t landmarks,
                                 std::size_t image, int clutter) {
    const mapping::ImageFeatures seen = place_.Photo(place_from_camera, 0);
    mapping::ImageFeatures some = RandomPlace(50 + image).Photo(Rigid3(), clutter);
    const std::size_t stride = seen.keypoints.size() / landmarks;
    for (std::size_t i = 0; i < landmarks; ++i) {
      const std::size_t chosen = (i * stride + 3 * image) % seen.keypoints.size();
      some.keypoints.push_back(seen.keypoints[chosen]);
      some.descriptors.push_back(seen.descriptors[chosen]);
    }
    return some;
  }

  static Rigid3 CarryPose(const Sim3& map_from_place, const Rigid3& place_from_camera) {
    return waymark::CarryPose(map_from_place, place_from_camera);
  }

  /// A walk past the front; `landmarks` of each image, 0: all that it sees.
  BurstRequest Walk(std::size_t images, std::size_t landmarks, double odometry_scale = 1,
                    int clutter = 60) {
    BurstRequest burst;
    for (std::size_t i = 0; i < images; ++i) {
      const Rigid3 there = Place(i);
      LocalisationRequest request = Request(there, clutter);
      if (landmarks > 0) request.image = Starved(there, landmarks, i, clutter);
      burst.images.push_back({std::move(request), InOdometry(there, odometry_scale)});
    }
    return burst;
  }
  Rigid3 Place(std::size_t image) const {
    return place_.Viewpoint(-2 + kStepM * static_cast<double>(image), -1);
  }
  double ErrorM(const Localisation& answer, std::size_t last) const {
    return (answer.pose->map_from_camera.translation() -
            CarryPose(kMapFromSubmap, Place(last)).translation())
        .norm();
  }
  mapping::ImageFeatures Elsewhere() {
    RandomPlace elsewhere(9);
    return elsewhere.Photo(elsewhere.Viewpoint(0), 50);
  }
};

TEST_F(BurstTest, FindsTogetherWhatNoImageShowsAlone) {
  const auto localiser = Open();
  const BurstRequest burst = Walk(5, 9);
  for (const BurstImage& image : burst.images) {
    EXPECT_FALSE(localiser->Localise(image.request).pose.has_value());
  }
  const Localisation answer = localiser->Localise(burst);
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  EXPECT_EQ(answer.status, LocalisationStatus::kLocalised);
  EXPECT_EQ(answer.pose->images, 5);
  EXPECT_GE(answer.pose->inliers, 30);
  EXPECT_LT(ErrorM(answer, 4), 0.1);
  EXPECT_LT((answer.pose->submap_from_camera.translation() - Place(4).translation()).norm(), 0.1);
  const Rigid3 truth = CarryPose(kMapFromSubmap, Place(4));
  EXPECT_LT(AngleBetween(answer.pose->map_from_camera.rotation(), truth.rotation()).degrees(), 0.5);
}

TEST_F(BurstTest, IsExactWhereEverythingIsSeen) {
  const Localisation answer = Open()->Localise(Walk(3, 0));
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  EXPECT_EQ(answer.pose->images, 3);
  EXPECT_LT(ErrorM(answer, 2), 0.03);
}

TEST_F(BurstTest, StandsAmongManyWrongMatches) {
  const Localisation answer = Open()->Localise(Walk(4, 14, 1, 400));
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  EXPECT_LT(ErrorM(answer, 3), 0.1);
}

TEST_F(BurstTest, StatesACovarianceThatHoldsItsErrors) {
  const auto localiser = Open();
  int inside = 0;
  constexpr int kTrials = 20;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Localisation answer = localiser->Localise(Walk(3, 40));
    ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
    const Eigen::Matrix<double, 6, 1> error =
        Difference(answer.pose->map_from_camera.rigid(), CarryPose(kMapFromSubmap, Place(2)));
    inside += error.dot(answer.pose->covariance.ldlt().solve(error)) < 16.8;  // 99 %
  }
  EXPECT_GE(inside, kTrials - 2);
}

TEST_F(BurstTest, NeedsNoStepBetweenImages) {
  BurstRequest burst;
  for (const double turn_rad : {0.5, 0.0, -0.5}) {
    const Rigid3 straight = Place(0);
    const Rigid3 there(RotationFromVector({0, 0, turn_rad}) * straight.rotation(),
                       straight.translation());
    LocalisationRequest request = Request(there);
    request.image = Starved(there, 10, burst.images.size(), 60);
    burst.images.push_back({std::move(request), InOdometry(there)});
  }
  const Localisation answer = Open()->Localise(burst);
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  EXPECT_LT(ErrorM(answer, 0), 0.15);
}

TEST_F(BurstTest, IsTheLastImageAloneWhereOnlyThatShowsTheMap) {
  BurstRequest burst = Walk(3, 0);
  burst.images[0].request.image = burst.images[1].request.image = Elsewhere();
  const Localisation answer = Open()->Localise(burst);
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  EXPECT_EQ(answer.pose->images, 1);
  EXPECT_LT(ErrorM(answer, 2), 0.05);
}

TEST_F(BurstTest, CarriesAnEarlierImageToTheLastOneWithTheDoubtOfTheWay) {
  BurstRequest burst = Walk(3, 0);
  burst.images[1].request.image = burst.images[2].request.image = Elsewhere();
  const Localisation answer = Open()->Localise(burst);
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  EXPECT_EQ(answer.pose->images, 1);
  EXPECT_LT(ErrorM(answer, 2), 0.1);
  const double way_m = kMapFromSubmap.scale() * 2 * kStepM;
  EXPECT_GT(std::sqrt(answer.pose->covariance.diagonal().head<3>().minCoeff()), 0.019 * way_m);
}

TEST_F(BurstTest, TrustsItsImagesMoreThanWrongOdometry) {
  const auto localiser = Open();
  for (const double scale : {0.5, 1.6, 3.0}) {
    const Localisation answer = localiser->Localise(Walk(4, 0, scale));
    ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
    EXPECT_EQ(answer.pose->images, 1);
    EXPECT_THAT(answer.reason, HasSubstr("odometry contradicts"));
    EXPECT_LT(ErrorM(answer, 3), 0.05);
  }
}

TEST_F(BurstTest, WithoutAFallbackIsAllImagesOrNothing) {
  const auto localiser = Open();
  BurstRequest burst = Walk(4, 0, 1.6);
  burst.fallback = BurstFallback::kNone;
  const Localisation wrong = localiser->Localise(burst);
  EXPECT_FALSE(wrong.pose.has_value());
  EXPECT_EQ(wrong.status, LocalisationStatus::kNoConsistentPose);
  EXPECT_THAT(wrong.reason, HasSubstr("odometry contradicts"));
  burst = Walk(4, 0);
  burst.fallback = BurstFallback::kNone;
  const Localisation right = localiser->Localise(burst);
  ASSERT_TRUE(right.pose.has_value()) << right.reason;
  EXPECT_EQ(right.pose->images, 4);
}

TEST_F(BurstTest, WithoutAFallbackIsNotCarriedByOdometryAlone) {
  BurstRequest burst = Walk(3, 0);
  burst.fallback = BurstFallback::kNone;
  burst.images[2].request.image = Elsewhere();
  const Localisation answer = Open()->Localise(burst);
  EXPECT_FALSE(answer.pose.has_value());
  EXPECT_THAT(answer.reason, HasSubstr("odometry alone speaks for the last image"));
}

TEST_F(BurstTest, IsRefusedWhereOdometryIsWrongAndNoImageStandsAlone) {
  const Localisation answer = Open()->Localise(Walk(5, 9, 2));
  EXPECT_FALSE(answer.pose.has_value()) << answer.reason;
  EXPECT_NE(answer.status, LocalisationStatus::kLocalised);
}

TEST_F(BurstTest, CountsAPictureThatIsRepeatedOnce) {
  BurstRequest burst = Walk(1, 11);
  burst.images.resize(8, burst.images.front());
  const Localisation answer = Open()->Localise(burst);
  EXPECT_FALSE(answer.pose.has_value()) << answer.reason;
}

TEST_F(BurstTest, OfAPlaceThatIsNotMappedIsRefused) {
  BurstRequest burst = Walk(4, 0);
  for (BurstImage& image : burst.images) image.request.image = Elsewhere();
  const Localisation answer = Open()->Localise(burst);
  EXPECT_FALSE(answer.pose.has_value());
  EXPECT_EQ(answer.status, LocalisationStatus::kTooFewMatches);
}

TEST_F(BurstTest, TwoPlacesThatLookAlikeAreNoAnswer) {
  disk_.Add(place_.Model(), Sim3(1, Eigen::Quaterniond::Identity(), {180, 0, 0}));
  const Localisation answer = Open()->Localise(Walk(3, 0));
  EXPECT_EQ(answer.status, LocalisationStatus::kNoConsistentPose);
  EXPECT_THAT(answer.reason, HasSubstr("look alike"));
}

TEST_F(BurstTest, EveryPriorMustHold) {
  BurstRequest burst = Walk(3, 9 * 3);
  const Eigen::Vector3d there = CarryPose(kMapFromSubmap, Place(0)).translation();
  const auto localiser = Open();
  for (BurstImage& image : burst.images) image.request.prior = {Point<Map>(there), 30};
  EXPECT_TRUE(localiser->Localise(burst).pose.has_value());
  burst.images[0].request.prior = {Point<Map>(there + Eigen::Vector3d(45, 0, 0)), 30};
  const Localisation answer = localiser->Localise(burst);
  EXPECT_EQ(answer.status, LocalisationStatus::kNoConsistentPose);
  EXPECT_THAT(answer.reason, AllOf(HasSubstr("image 1 of 3"), HasSubstr("prior")));
}

TEST_F(BurstTest, TakesGravityThatIsOffByTwoDegrees) {
  BurstRequest burst = Walk(4, 12);
  const Eigen::Quaterniond lean = RotationFromVector({0.03, -0.015, 0});
  for (BurstImage& image : burst.images) {
    const Rigid3 leaning(lean, Eigen::Vector3d::Zero());
    image.vo_from_camera = Transform<Vo, Camera>(leaning * image.vo_from_camera.rigid());
  }
  const Localisation answer = Open()->Localise(burst);
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  EXPECT_LT(ErrorM(answer, 3), 0.15);
}

TEST_F(BurstTest, FindsALensThatIsLongerThanStated) {
  BurstRequest burst = Walk(3, 0);
  for (BurstImage& image : burst.images) {
    image.request.camera = image.request.camera.WithScaledFocal(1.05);
  }
  const auto localiser = Open();
  const Localisation answer = localiser->Localise(burst);
  ASSERT_TRUE(answer.pose.has_value()) << answer.reason;
  EXPECT_LT(ErrorM(answer, 2), 0.1);
  for (BurstImage& image : burst.images) {
    image.request.camera = image.request.camera.WithScaledFocal(1.25);
  }
  EXPECT_FALSE(localiser->Localise(burst).pose.has_value());
}

TEST_F(BurstTest, IsTheSameEachTime) {
  const auto localiser = Open();
  const BurstRequest burst = Walk(3, 12);
  const Localisation once = localiser->Localise(burst), again = localiser->Localise(burst);
  ASSERT_TRUE(once.pose.has_value()) << once.reason;
  EXPECT_EQ(once.pose->map_from_camera.translation(), again.pose->map_from_camera.translation());
  EXPECT_EQ(once.pose->covariance, again.pose->covariance);
}

TEST_F(BurstTest, ThatContradictsItselfIsInvalid) {
  const auto localiser = Open();
  const BurstRequest good = Walk(2, 12);
  const auto status_of = [&](auto&& spoil) {
    BurstRequest burst = good;
    spoil(burst);
    return localiser->Localise(burst).status;
  };
  const auto invalid = LocalisationStatus::kInvalidRequest;
  EXPECT_EQ(status_of([](BurstRequest& burst) { burst.images.clear(); }), invalid);
  EXPECT_EQ(status_of([](BurstRequest& burst) { burst.images.pop_back(); }), invalid);
  EXPECT_EQ(status_of([&](BurstRequest& burst) { burst.images.resize(17, good.images[0]); }),
            invalid);
  for (const double bad : {double{NAN}, double{INFINITY}, 1e300}) {
    EXPECT_EQ(status_of([&](BurstRequest& burst) {
                burst.images[0].vo_from_camera = {Eigen::Quaterniond::Identity(), {0, bad, 0}};
              }),
              invalid);
  }
  EXPECT_EQ(status_of([](BurstRequest& burst) {
              burst.images[1].vo_from_camera = {Eigen::Quaterniond(0, 0, 0, 0), {0, 0, 0}};
            }),
            invalid);
  EXPECT_EQ(status_of([](BurstRequest& burst) {
              burst.images[1].request.up_in_camera = Eigen::Vector3d(1, 0, 0);
            }),
            invalid);
  EXPECT_EQ(
      status_of([](BurstRequest& burst) {
        std::get<mapping::ImageFeatures>(burst.images[0].request.image).descriptors.pop_back();
      }),
      invalid);
}

}  // namespace
}  // namespace waymark::localiser
