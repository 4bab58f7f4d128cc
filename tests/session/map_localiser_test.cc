// SPDX-License-Identifier: Apache-2.0
// What a phone may send in place of a picture, and that the answer is the same.
#include "session/server/map_localiser.h"

#include <gmock/gmock.h>

#include <cstring>

#include "mapping/features/feature_codec.h"
#include "session/device/jpeg.h"
#include "tests/localiser/map_on_disk.h"
#include "tests/session/pictured_map.h"

namespace waymark::session {
namespace {

using support::kPictureHeight;
using support::kPictureWidth;
using support::MapOf;
using support::Picture;
using support::TestCamera;

class FeatureQueries : public testing::Test {
 protected:
  FeatureQueries() : jpeg_(EncodeJpeg(Picture(), kPictureWidth, kPictureHeight, {})->jpeg) {
    const auto image = mapping::DecodeGrayImage(jpeg_);
    features_ = *mapping::ExtractFeatures(*image, localiser::LocaliserOptions{}.features);
    disk_.Add(MapOf(features_));
    localise_ = MakeLocaliseFunction(
        *localiser::Localiser::Create(disk_.map(), disk_.release(), {}), disk_.map().description());
  }

  LocaliseQuery Query(std::vector<std::uint8_t> content) const {
    return {.ticket = {},
            .request = {},
            .time = {},
            .camera = TestCamera(),
            .prior = std::nullopt,
            .up_in_camera = std::nullopt,
            .image = std::move(content)};
  }

  localiser::MapOnDisk disk_;
  std::vector<std::uint8_t> jpeg_;
  mapping::ImageFeatures features_;
  LocaliseFunction localise_;
};

TEST_F(FeatureQueries, AreAnsweredToTheBitAsThePictureIs) {
  const auto picture = localise_(Query(jpeg_));
  const auto features = localise_(Query(mapping::EncodeFeatures(features_)));
  ASSERT_TRUE(picture.ok() && features.ok());
  ASSERT_TRUE(picture->pose.has_value()) << picture->reason;
  ASSERT_TRUE(features->pose.has_value()) << features->reason;
  EXPECT_EQ(picture->reason, features->reason);
  EXPECT_EQ(picture->pose->inliers, features->pose->inliers);
  const auto bits = [](const localiser::LocalisedPose& pose) {
    std::array<double, 43> numbers;
    const Rigid3& rigid = pose.map_from_camera.rigid();
    std::copy_n(rigid.rotation().coeffs().data(), 4, numbers.begin());
    std::copy_n(rigid.translation().data(), 3, numbers.begin() + 4);
    std::copy_n(pose.covariance.data(), 36, numbers.begin() + 7);
    return numbers;
  };
  EXPECT_EQ(bits(*picture->pose), bits(*features->pose));
}

TEST_F(FeatureQueries, BeyondThoseOfAPictureCountForNothing) {
  mapping::ImageFeatures many = features_;
  const auto limit = static_cast<std::size_t>(localiser::LocaliserOptions{}.features.max_features);
  while (many.keypoints.size() < limit) {
    many.keypoints.push_back({.x_px = 1, .y_px = 1, .scale_px = 2, .angle_rad = 0});
    many.descriptors.emplace_back();
  }
  const auto once = localise_(Query(mapping::EncodeFeatures(many)));
  many.keypoints.insert(many.keypoints.end(), features_.keypoints.begin(),
                        features_.keypoints.end());
  many.descriptors.insert(many.descriptors.end(), features_.descriptors.begin(),
                          features_.descriptors.end());
  const auto twice = localise_(Query(mapping::EncodeFeatures(many)));
  ASSERT_TRUE(once.ok() && twice.ok() && once->pose && twice->pose);
  EXPECT_EQ(once->reason, twice->reason);
}

TEST_F(FeatureQueries, ThatAreDamagedAreThePhonesFault) {
  std::vector<std::uint8_t> bytes = mapping::EncodeFeatures(features_);
  bytes[500] ^= 1;
  EXPECT_EQ(localise_(Query(bytes)).error().code, ErrorCode::kCorrupt);
  bytes.resize(bytes.size() / 2);
  EXPECT_EQ(localise_(Query(bytes)).error().code, ErrorCode::kCorrupt);
}

TEST_F(FeatureQueries, OutsideTheImageAreRefusedWithAReason) {
  mapping::ImageFeatures features = features_;
  features.keypoints.front().x_px = 1e6;
  const auto answer = localise_(Query(mapping::EncodeFeatures(features)));
  ASSERT_TRUE(answer.ok());
  EXPECT_EQ(answer->status, localiser::LocalisationStatus::kInvalidRequest);
}

}  // namespace
}  // namespace waymark::session
