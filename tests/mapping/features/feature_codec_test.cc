// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/feature_codec.h"

#include <gmock/gmock.h>

#include <cstring>
#include <limits>
#include <random>

#include "mapping/base/content_hash.h"

namespace waymark::mapping {
namespace {

constexpr std::size_t kHeaderBytes = 24;

ImageFeatures RandomFeatures(std::size_t count) {
  std::mt19937 random(7);
  ImageFeatures features;
  for (std::size_t i = 0; i < count; ++i) {
    const auto number = [&] { return static_cast<float>(random() % 100'000) / 7; };
    features.keypoints.push_back({number(), number(), number(), number()});
    Descriptor& descriptor = features.descriptors.emplace_back();
    for (std::uint8_t& value : descriptor) value = static_cast<std::uint8_t>(random());
  }
  return features;
}

/// Makes a changed body pass the checksum, as an attacker would.
void Reseal(std::vector<std::uint8_t>& bytes) {
  const std::uint64_t checksum = Checksum(std::span(bytes).subspan(kHeaderBytes));
  std::memcpy(bytes.data() + 16, &checksum, sizeof(checksum));
}

TEST(FeatureCodec, DecodeUndoesEncode) {
  for (const std::size_t count : {0, 1, 5, 1000}) {
    const ImageFeatures features = RandomFeatures(count);
    const auto bytes = EncodeFeatures(features);
    EXPECT_EQ(bytes.size(), kHeaderBytes + 144 * count);
    const auto decoded = DecodeFeatures(bytes);
    ASSERT_TRUE(decoded.ok()) << ToString(decoded.error());
    EXPECT_EQ(decoded->descriptors, features.descriptors);
    ASSERT_EQ(decoded->keypoints.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(decoded->keypoints[i].x_px, features.keypoints[i].x_px);
      EXPECT_EQ(decoded->keypoints[i].y_px, features.keypoints[i].y_px);
      EXPECT_EQ(decoded->keypoints[i].scale_px, features.keypoints[i].scale_px);
      EXPECT_EQ(decoded->keypoints[i].angle_rad, features.keypoints[i].angle_rad);
    }
    EXPECT_EQ(EncodeFeatures(*decoded), bytes);
  }
}

TEST(FeatureCodec, BytesStayAsDocumented) {
  ImageFeatures features;
  features.keypoints.push_back({1, 2, 3, 4});
  features.descriptors.emplace_back().fill(9);
  const auto bytes = EncodeFeatures(features);
  EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 8), "WAYMFEAT");
  EXPECT_THAT(std::span(bytes).subspan(8, 8), testing::ElementsAre(1, 0, 0, 0, 1, 0, 0, 0));
  EXPECT_THAT(std::span(bytes).subspan(24, 8), testing::ElementsAre(0, 0, 0x80, 0x3f, 0, 0, 0, 64));
  EXPECT_EQ(bytes.back(), 9);
}

TEST(FeatureCodec, EveryTruncationAndExtensionIsCorrupt) {
  const auto bytes = EncodeFeatures(RandomFeatures(3));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto decoded = DecodeFeatures(std::span(bytes).first(size));
    ASSERT_FALSE(decoded.ok()) << size;
    EXPECT_EQ(decoded.error().code, ErrorCode::kCorrupt);
  }
  auto longer = bytes;
  longer.push_back(0);
  EXPECT_FALSE(DecodeFeatures(longer).ok());
}

TEST(FeatureCodec, EveryFlippedBitIsFound) {
  const auto bytes = EncodeFeatures(RandomFeatures(2));
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    auto damaged = bytes;
    damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    EXPECT_FALSE(DecodeFeatures(damaged).ok()) << "bit " << bit;
  }
}

TEST(FeatureCodec, AHugeCountIsRefusedBeforeAllocation) {
  auto bytes = EncodeFeatures(RandomFeatures(1));
  std::memset(bytes.data() + 12, 0xff, 4);
  const auto decoded = DecodeFeatures(bytes);
  ASSERT_FALSE(decoded.ok());
  EXPECT_EQ(decoded.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(decoded.error().message, testing::HasSubstr("4294967295 features"));
}

TEST(FeatureCodec, AnotherVersionIsUnsupported) {
  auto bytes = EncodeFeatures(RandomFeatures(1));
  bytes[8] = 2;
  EXPECT_EQ(DecodeFeatures(bytes).error().code, ErrorCode::kUnsupported);
}

TEST(FeatureCodec, NumbersThatAreNotFiniteAreCorrupt) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    for (std::size_t field = 0; field < 4; ++field) {
      auto bytes = EncodeFeatures(RandomFeatures(2));
      std::memcpy(bytes.data() + kHeaderBytes + 16 + 4 * field, &bad, sizeof(bad));
      Reseal(bytes);
      const auto decoded = DecodeFeatures(bytes);
      ASSERT_FALSE(decoded.ok());
      EXPECT_THAT(decoded.error().message, testing::HasSubstr("keypoint 1"));
    }
  }
}

}  // namespace
}  // namespace waymark::mapping
