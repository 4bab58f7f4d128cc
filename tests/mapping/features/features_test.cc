// SPDX-License-Identifier: Apache-2.0
#include "mapping/features/features.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "mapping/base/parallel.h"

namespace waymark::mapping {
namespace {

/// A bright or dark Gaussian spot; in our pixel convention.
struct Blob {
  double x_px;
  double y_px;
  double sigma_px;
  double height;
  double elongation = 1;  ///< longer along x by this factor
};

GrayImage Render(int width_px, int height_px, const std::vector<Blob>& blobs) {
  GrayImage image{.width_px = width_px, .height_px = height_px, .pixels = {}};
  for (int row = 0; row < height_px; ++row) {
    for (int column = 0; column < width_px; ++column) {
      double value = 128;
      for (const Blob& blob : blobs) {
        const double dx = (column + 0.5 - blob.x_px) / (blob.sigma_px * blob.elongation);
        const double dy = (row + 0.5 - blob.y_px) / blob.sigma_px;
        const double exponent = (dx * dx + dy * dy) / 2;
        if (exponent < 12) value += blob.height * std::exp(-exponent);
      }
      image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)));
    }
  }
  return image;
}

std::vector<Blob> RandomBlobs(double side_px, std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(0.05 * side_px, 0.95 * side_px), size(1.5, 5),
      height(30, 90), elongation(1, 2.5);
  std::vector<Blob> blobs;
  for (std::size_t i = 0; i < count; ++i) {
    const double sign = random() % 2 == 0 ? 1 : -1;
    blobs.push_back(
        {place(random), place(random), size(random), sign * height(random), elongation(random)});
  }
  return blobs;
}

ImageFeatures Extract(const GrayImage& image, const FeatureOptions& options = {}) {
  auto features = ExtractFeatures(image, options);
  EXPECT_TRUE(features.ok()) << ToString(features.error());
  return *std::move(features);
}

int SquaredDistance(const Descriptor& a, const Descriptor& b) {
  int sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

bool SameFeatures(const ImageFeatures& a, const ImageFeatures& b) {
  const auto same = [](const Keypoint& x, const Keypoint& y) {
    return x.x_px == y.x_px && x.y_px == y.y_px && x.scale_px == y.scale_px &&
           x.angle_rad == y.angle_rad;
  };
  return std::ranges::equal(a.keypoints, b.keypoints, same) && a.descriptors == b.descriptors;
}

TEST(ExtractFeatures, ABlobIsFoundAtItsCentreWithoutBias) {
  double sum_x_px = 0, sum_y_px = 0;
  int rendered = 0, found = 0;
  for (const double sigma_px : {1.0, 1.5, 2.0, 3.0, 4.5, 7.0, 10.0}) {
    for (int i = 0; i < 5; ++i) {
      const Blob blob{64 + i * 0.2, 64 + i * 2 % 5 * 0.2, sigma_px, 100};
      const ImageFeatures features = Extract(Render(128, 128, {blob}));
      ++rendered;
      if (features.keypoints.empty()) continue;  // a few fall between two octaves
      const Keypoint& strongest = features.keypoints.front();
      EXPECT_NEAR(strongest.x_px, blob.x_px, 0.1) << "sigma " << sigma_px;
      EXPECT_NEAR(strongest.y_px, blob.y_px, 0.1) << "sigma " << sigma_px;
      EXPECT_NEAR(strongest.scale_px, 2 * sigma_px, 0.3 * sigma_px);
      sum_x_px += strongest.x_px - blob.x_px;
      sum_y_px += strongest.y_px - blob.y_px;
      ++found;
    }
  }
  EXPECT_GT(found, 0.9 * rendered);
  EXPECT_NEAR(sum_x_px / found, 0, 0.01);
  EXPECT_NEAR(sum_y_px / found, 0, 0.01);
}

TEST(ExtractFeatures, AReducedImageHasItsKeypointsInFullPixels) {
  for (const double shift_px : {0.0, 0.7, 1.3}) {
    const Blob blob{150 + shift_px, 90 - shift_px, 12, 100};
    const ImageFeatures features = Extract(Render(301, 200, {blob}), {.max_image_side_px = 100});
    ASSERT_FALSE(features.keypoints.empty());
    EXPECT_NEAR(features.keypoints.front().x_px, blob.x_px, 0.2);
    EXPECT_NEAR(features.keypoints.front().y_px, blob.y_px, 0.2);
    EXPECT_NEAR(features.keypoints.front().scale_px, 24, 3);
  }
}

TEST(ExtractFeatures, AnglesTurnClockwiseFromX) {
  double sum_rad = 0;
  int found = 0;
  for (int i = 0; i < 24; ++i) {
    // The flank of a wide blob is a slope that ascends in this direction. A small blob on it has
    // one or two orientations to either side of the slope's.
    const double direction_rad = 0.1 + i * std::numbers::pi / 12;
    const Blob slope{64 + 40 * std::cos(direction_rad), 64 + 40 * std::sin(direction_rad), 40, 100};
    const ImageFeatures features = Extract(Render(128, 128, {{64, 64, 4, 15}, slope}));
    for (const Keypoint& keypoint : features.keypoints) {
      if (std::hypot(keypoint.x_px - 64, keypoint.y_px - 64) > 2) continue;
      const double turn = std::remainder(keypoint.angle_rad - direction_rad, 2 * std::numbers::pi);
      EXPECT_NEAR(turn, 0, 0.5) << direction_rad;
      sum_rad += turn;
      ++found;
    }
  }
  ASSERT_GE(found, 24);
  EXPECT_NEAR(sum_rad / found, 0, 0.03);
}

/// How many features of one image reappear where `map` sends them, with a similar descriptor.
template <typename Map>
double Repeatability(const ImageFeatures& from, const ImageFeatures& to, double tolerance_px,
                     const Map& map) {
  int repeated = 0;
  for (std::size_t i = 0; i < from.keypoints.size(); ++i) {
    const auto [x_px, y_px] = map(from.keypoints[i]);
    for (std::size_t j = 0; j < to.keypoints.size(); ++j) {
      if (std::hypot(to.keypoints[j].x_px - x_px, to.keypoints[j].y_px - y_px) < tolerance_px &&
          SquaredDistance(from.descriptors[i], to.descriptors[j]) < 150 * 150) {
        ++repeated;
        break;
      }
    }
  }
  return repeated / static_cast<double>(from.keypoints.size());
}

TEST(ExtractFeatures, FollowsAShift) {
  const std::vector<Blob> blobs = RandomBlobs(300, 150, 1);
  std::vector<Blob> shifted = blobs;
  for (Blob& blob : shifted) blob.x_px += 5.3, blob.y_px -= 2.6;
  const ImageFeatures a = Extract(Render(300, 300, blobs), {.max_features = 100});
  const ImageFeatures b = Extract(Render(300, 300, shifted));
  EXPECT_GT(Repeatability(a, b, 0.3,
                          [](const Keypoint& keypoint) {
                            return std::pair(keypoint.x_px + 5.3, keypoint.y_px - 2.6);
                          }),
            0.7);
}

TEST(ExtractFeatures, FollowsAChangeOfScale) {
  const std::vector<Blob> blobs = RandomBlobs(300, 150, 2);
  std::vector<Blob> larger = blobs;
  for (Blob& blob : larger) blob.x_px *= 1.5, blob.y_px *= 1.5, blob.sigma_px *= 1.5;
  const ImageFeatures a = Extract(Render(300, 300, blobs), {.max_features = 100});
  const ImageFeatures b = Extract(Render(450, 450, larger));
  EXPECT_GT(Repeatability(a, b, 0.5,
                          [](const Keypoint& keypoint) {
                            return std::pair(keypoint.x_px * 1.5, keypoint.y_px * 1.5);
                          }),
            0.6);
}

TEST(ExtractFeatures, GivesTheSameOnEveryRunAndThread) {
  const GrayImage image = Render(300, 300, RandomBlobs(300, 200, 3));
  const ImageFeatures expected = Extract(image);
  std::vector<ImageFeatures> again(6);
  ParallelFor(again.size(), {.threads = 3}, [&](std::size_t i) { again[i] = Extract(image); });
  for (const ImageFeatures& features : again) EXPECT_TRUE(SameFeatures(features, expected));
}

TEST(ExtractFeatures, ALimitKeepsTheStrongest) {
  const GrayImage image = Render(300, 300, RandomBlobs(300, 200, 4));
  const ImageFeatures all = Extract(image);
  for (const int limit : {1, 2, 10, 57, 100}) {
    const ImageFeatures few = Extract(image, {.max_features = limit});
    ASSERT_EQ(few.keypoints.size(), limit);
    ImageFeatures expected = all;
    expected.keypoints.resize(limit);
    expected.descriptors.resize(limit);
    EXPECT_TRUE(SameFeatures(few, expected)) << limit;
  }
}

TEST(ExtractFeatures, TiesAreBrokenByPlace) {
  std::vector<Blob> blobs;  // a grid of equal blobs: equal responses
  for (int i = 0; i < 36; ++i) blobs.push_back({40.5 + i % 6 * 32, 40.5 + i / 6 * 32, 4, 80});
  const GrayImage image = Render(240, 240, blobs);
  const ImageFeatures all = Extract(image);
  const ImageFeatures few = Extract(image, {.max_features = 7});
  ASSERT_EQ(few.keypoints.size(), 7);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(few.keypoints[i].x_px, all.keypoints[i].x_px);
    EXPECT_EQ(few.keypoints[i].y_px, all.keypoints[i].y_px);
  }
}

TEST(ExtractFeatures, DescriptorsAreUnitVectorsOf512) {
  const ImageFeatures features = Extract(Render(300, 300, RandomBlobs(300, 200, 5)));
  ASSERT_EQ(features.keypoints.size(), features.descriptors.size());
  for (const Descriptor& descriptor : features.descriptors) {
    EXPECT_NEAR(std::sqrt(SquaredDistance(descriptor, Descriptor{})), 512, 16);
  }
}

TEST(ExtractFeatures, ImagesWithoutTextureHaveNone) {
  EXPECT_TRUE(Extract(GrayImage{}).keypoints.empty());
  for (const int side_px : {1, 2, 3, 7, 64}) {
    GrayImage flat{.width_px = side_px, .height_px = side_px, .pixels = {}};
    flat.pixels.assign(static_cast<std::size_t>(side_px * side_px), 200);
    EXPECT_TRUE(Extract(flat).keypoints.empty());
  }
  GrayImage line{.width_px = 5000, .height_px = 1, .pixels = std::vector<std::uint8_t>(5000, 9)};
  EXPECT_TRUE(Extract(line).keypoints.empty());
}

TEST(ExtractFeatures, RefusesInvalidInput) {
  const GrayImage image = Render(32, 32, {});
  for (const FeatureOptions& options :
       {FeatureOptions{.max_features = 0}, FeatureOptions{.max_features = 100'001},
        FeatureOptions{.contrast_threshold = 0}, FeatureOptions{.contrast_threshold = std::nan("")},
        FeatureOptions{.smoothing_px = -1}, FeatureOptions{.smoothing_px = std::nan("")},
        FeatureOptions{.max_image_side_px = 0}}) {
    const auto features = ExtractFeatures(image, options);
    ASSERT_FALSE(features.ok());
    EXPECT_EQ(features.error().code, ErrorCode::kInvalidArgument);
  }
  GrayImage torn = image;
  torn.pixels.pop_back();
  EXPECT_EQ(ExtractFeatures(torn, {}).error().code, ErrorCode::kInvalidArgument);
  torn.width_px = -32;
  torn.height_px = -32;
  EXPECT_EQ(ExtractFeatures(torn, {}).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace waymark::mapping
