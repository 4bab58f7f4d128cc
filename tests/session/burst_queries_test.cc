// SPDX-License-Identifier: Apache-2.0
// Images that are not found alone, and are together.
#include <gmock/gmock.h>

#include "mapping/features/feature_codec.h"
#include "session/device/jpeg.h"
#include "session/server/map_localiser.h"
#include "tests/localiser/map_on_disk.h"
#include "tests/session/pictured_map.h"

namespace waymark::session {
namespace {

using localiser::LocalisationStatus;
using testing::HasSubstr;
using testing::Not;

constexpr Ticket kAnna{1}, kBen{2};

class BurstQueries : public testing::Test {
 protected:
  BurstQueries()
      : features_(*mapping::ExtractFeatures(
            {support::kPictureWidth, support::kPictureHeight, support::Picture()}, {})),
        model_(support::MapOf(features_)) {
    disk_.Add(model_);
    localiser_ = *localiser::Localiser::Create(disk_.map(), disk_.release(), {});
    localise_ = MakeLocaliseFunction(localiser_, disk_.map().description(), unfound_);
  }

  static Transform<Map, Camera> At(double x_m, double y_m) {
    return {Eigen::Quaterniond::Identity(), {x_m, y_m, 0}};
  }

  /// Some of the landmarks, as a camera there sees them: every n-th, from the k-th on.
  mapping::ImageFeatures See(const Transform<Map, Camera>& map_from_camera, std::size_t n,
                             std::size_t k) const {
    const CameraModel camera = support::TestCamera();
    mapping::ImageFeatures seen;
    for (std::size_t i = k; i < features_.keypoints.size(); i += n) {
      const Eigen::Vector3d in_camera =
          map_from_camera.rigid().Inverse() * model_.landmarks[i].coordinates();
      const auto pixel_px = camera.Project(in_camera);
      if (!pixel_px || !camera.Contains(*pixel_px)) continue;
      mapping::Keypoint keypoint = features_.keypoints[i];
      keypoint.x_px = static_cast<float>(pixel_px->x());
      keypoint.y_px = static_cast<float>(pixel_px->y());
      seen.keypoints.push_back(keypoint);
      seen.descriptors.push_back(features_.descriptors[i]);
    }
    return seen;
  }

  /// A thin share of what a camera there sees, too little to be found alone; each request another.
  LocaliseQuery StarvedQuery(std::uint32_t request, const Transform<Map, Camera>& there,
                             const std::vector<EarlierImage>& earlier = {}) const {
    const std::size_t share = features_.keypoints.size() / 12;
    return {.ticket = kAnna,
            .request = RequestNumber{request},
            .time = {},
            .camera = support::TestCamera(),
            .prior = std::nullopt,
            .up_in_camera = std::nullopt,
            .image = mapping::EncodeFeatures(See(there, share, request)),
            .vo_from_camera = Odometry(there),
            .earlier = earlier};
  }
  /// It began somewhere else, and turned.
  static Transform<Vo, Camera> Odometry(const Transform<Map, Camera>& map_from_camera) {
    const Transform<Vo, Map> vo_from_map(
        Eigen::Quaterniond(Eigen::AngleAxisd(1, Eigen::Vector3d::UnitZ())), {30, -20, 5});
    return vo_from_map * map_from_camera;
  }

  localiser::Localisation Ask(const LocaliseQuery& query) const {
    auto answer = localise_(query);
    EXPECT_TRUE(answer.ok()) << ToString(answer.error());
    return *std::move(answer);
  }

  const mapping::ImageFeatures features_;
  const mapping::SubmapModel model_;
  localiser::MapOnDisk disk_;
  std::shared_ptr<UnfoundImages> unfound_ = std::make_shared<UnfoundImages>();
  std::shared_ptr<const localiser::Localiser> localiser_;
  LocaliseFunction localise_;
  const Transform<Map, Camera> first_ = At(0, 0), second_ = At(1, 0.3), third_ = At(1.4, -0.5);
};

TEST_F(BurstQueries, AreFoundTogetherWhereNoneIsAlone) {
  EXPECT_FALSE(Ask(StarvedQuery(1, first_)).pose);
  EXPECT_FALSE(Ask(StarvedQuery(2, second_)).pose) << "names nothing";
  EXPECT_FALSE(Ask(StarvedQuery(3, first_)).pose);
  const auto answer = Ask(StarvedQuery(4, second_, {{RequestNumber{3}, Odometry(first_)}}));
  ASSERT_TRUE(answer.pose) << answer.reason;
  EXPECT_EQ(answer.pose->images, 2);
  EXPECT_LT((answer.pose->map_from_camera.translation() - second_.translation()).norm(), 0.05);
  EXPECT_GT(answer.times.search_ms, 0);
}

TEST_F(BurstQueries, EvidenceCountsOnce) {
  Ask(StarvedQuery(1, first_));
  const std::vector<EarlierImage> earlier{{RequestNumber{1}, Odometry(first_)}};
  ASSERT_TRUE(Ask(StarvedQuery(2, second_, earlier)).pose);
  EXPECT_EQ(unfound_->bytes(), 0u);
  EXPECT_FALSE(Ask(StarvedQuery(3, third_, earlier)).pose);
}

TEST_F(BurstQueries, AreOfOnePhone) {
  Ask(StarvedQuery(1, first_));
  LocaliseQuery bens = StarvedQuery(2, second_, {{RequestNumber{1}, Odometry(first_)}});
  bens.ticket = kBen;
  EXPECT_FALSE(Ask(bens).pose);
}

TEST_F(BurstQueries, AFalseOdometryFindsNothing) {
  const Transform<Vo, Camera> truth = Odometry(first_);
  const Transform<Vo, Camera> turned(
      truth.rotation() * Eigen::AngleAxisd(0.35, Eigen::Vector3d::UnitZ()), truth.translation());
  const Transform<Vo, Camera> elsewhere(truth.rotation(),
                                        truth.translation() + Eigen::Vector3d(4, 3, 0));
  std::uint32_t request = 1;
  for (const auto& lie : {turned, elsewhere}) {
    Ask(StarvedQuery(request, first_));
    const auto answer = Ask(StarvedQuery(request + 1, second_, {{RequestNumber{request}, lie}}));
    EXPECT_FALSE(answer.pose);
    EXPECT_THAT(answer.reason, HasSubstr("2 images together"));
    request += 2;
  }
}

TEST_F(BurstQueries, ContradictingNumbersLeaveTheImageAlone) {
  Ask(StarvedQuery(1, first_));
  const Transform<Vo, Camera> far(Eigen::Quaterniond::Identity(), {2e5, 0, 0});
  const auto starved = Ask(StarvedQuery(2, second_, {{RequestNumber{1}, far}}));
  EXPECT_EQ(starved.status, LocalisationStatus::kTooFewFeatures);
  LocaliseQuery whole = StarvedQuery(3, second_, {{RequestNumber{2}, far}});
  whole.image = mapping::EncodeFeatures(See(second_, 1, 0));
  const auto found = Ask(whole);
  ASSERT_TRUE(found.pose);
  EXPECT_EQ(found.pose->images, 1);
}

TEST_F(BurstQueries, NothingIsKeptOfWhoStatesNoOdometry) {
  LocaliseQuery query = StarvedQuery(1, first_);
  query.vo_from_camera.reset();
  EXPECT_FALSE(Ask(query).pose);
  EXPECT_EQ(unfound_->bytes(), 0u);
}

TEST_F(BurstQueries, AnswerAPictureAsIfItWereAlone) {
  LocaliseQuery query = StarvedQuery(1, first_);
  query.image =
      EncodeJpeg(support::Picture(), support::kPictureWidth, support::kPictureHeight, {})->jpeg;
  const auto with_odometry = Ask(query);
  query.vo_from_camera.reset();
  const auto without = Ask(query);
  ASSERT_TRUE(with_odometry.pose && without.pose);
  EXPECT_EQ(with_odometry.reason, without.reason);
  EXPECT_EQ(with_odometry.pose->map_from_camera.translation(),
            without.pose->map_from_camera.translation());
  EXPECT_EQ(with_odometry.pose->covariance, without.pose->covariance);
  EXPECT_GT(with_odometry.times.features_ms, 0);
}

TEST_F(BurstQueries, APictureThatIsNotItsCamerasIsRefused) {
  LocaliseQuery query = StarvedQuery(1, first_);
  query.image = EncodeJpeg(support::Picture(), support::kPictureWidth, support::kPictureHeight,
                           {.max_side_px = 200})
                    ->jpeg;
  EXPECT_EQ(Ask(query).status, LocalisationStatus::kInvalidRequest);
  EXPECT_EQ(unfound_->bytes(), 0u);
}

TEST_F(BurstQueries, KeepFeaturesOfWhatWasNotFoundAlone) {
  LocaliseQuery query = StarvedQuery(1, first_);
  query.image = mapping::EncodeFeatures(See(first_, 1, 0));
  EXPECT_TRUE(Ask(query).pose);
  EXPECT_EQ(unfound_->bytes(), 0u) << "found";
  EXPECT_FALSE(Ask(StarvedQuery(2, first_)).pose);
  EXPECT_GT(unfound_->bytes(), 0u);
  EXPECT_LT(unfound_->bytes(), 20u * 144 + sizeof(localiser::LocalisationRequest));
}

TEST_F(BurstQueries, OutliveARelease) {
  Ask(StarvedQuery(1, first_));
  localise_ = MakeLocaliseFunction(localiser_, disk_.map().description(), unfound_);
  EXPECT_TRUE(Ask(StarvedQuery(2, second_, {{RequestNumber{1}, Odometry(first_)}})).pose);
}

TEST_F(BurstQueries, AreNotAskedByWhoKeepsNothing) {
  localise_ = MakeLocaliseFunction(localiser_, disk_.map().description());
  Ask(StarvedQuery(1, first_));
  const auto answer = Ask(StarvedQuery(2, second_, {{RequestNumber{1}, Odometry(first_)}}));
  EXPECT_FALSE(answer.pose);
  EXPECT_THAT(answer.reason, Not(HasSubstr("together")));
}

TEST_F(BurstQueries, AreBoundedInWhatTheyAskFor) {
  const auto limit = static_cast<std::size_t>(localiser_->options().features.max_features);
  mapping::ImageFeatures noise;
  noise.keypoints.assign(2 * limit, {.x_px = 1, .y_px = 1, .scale_px = 2, .angle_rad = 0});
  noise.descriptors.resize(2 * limit);
  std::vector<EarlierImage> earlier;
  std::string reason;
  for (std::uint32_t request = 1; request <= 8; ++request) {
    LocaliseQuery query = StarvedQuery(request, first_, earlier);
    query.image = mapping::EncodeFeatures(noise);
    reason = Ask(query).reason;
    earlier.push_back({RequestNumber{request}, Odometry(first_)});
  }
  EXPECT_THAT(reason, HasSubstr("; 5 images together"));
}

}  // namespace
}  // namespace waymark::session
