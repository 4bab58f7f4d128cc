// SPDX-License-Identifier: Apache-2.0
// Fixes from the other end of the city.
#include <gtest/gtest.h>

#include "tests/mapping/split/drives.h"

namespace waymark::mapping {
namespace {

std::vector<SplitImage> Without(std::vector<SplitImage> images,
                                const std::vector<std::size_t>& positions) {
  for (const std::size_t i : positions) images[i].position.reset();
  return images;
}

TEST(SplitOutliers, ADriveIsSplitAsIfWildPositionsWereAbsent) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const std::vector<SplitImage> images = Wander(400, 0.5 + 0.9 * seed, seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> angle(0, 6.28), power(2.5, 5);
    std::vector<SplitImage> spoilt = images;
    std::vector<std::size_t> wild;
    for (std::size_t i = 8 + random() % 20; i + 8 < images.size(); i += 8 + random() % 40) {
      if (!images[i].position) continue;
      const double away_m = std::pow(10, power(random)), direction = angle(random);
      const Eigen::Vector3d offset(away_m * std::cos(direction), away_m * std::sin(direction), 0);
      spoilt[i].position = Point<Map>(images[i].position->coordinates() + offset);
      wild.push_back(i);
    }
    ASSERT_GE(wild.size(), 8u);
    const auto split = SplitExperience(spoilt, {}, {});
    const auto expected = SplitExperience(Without(images, wild), {}, {});
    EXPECT_EQ(Describe(*split), Describe(*expected)) << "seed " << seed;
  }
}

TEST(SplitOutliers, AFixThatPicturesOfTwoSecondsShareIsOne) {
  std::vector<SplitImage> images;
  for (int i = 0; i < 200; ++i) images.push_back(At(0.1 * i, 1.5 * i, 0));
  std::vector<std::size_t> wild;
  for (std::size_t i = 95; i < 115; ++i) {
    images[i].position = Point<Map>(5000, 9000, 0);
    wild.push_back(i);
  }
  EXPECT_EQ(Describe(*SplitExperience(images, {}, {})),
            Describe(*SplitExperience(Without(images, wild), {}, {})));
}

TEST(SplitOutliers, FastDrivesAndPhotosFarApartKeepTheirPositions) {
  std::vector<SplitImage> fast, photos;
  for (int i = 0; i < 60; ++i) {
    fast.push_back(At(0.5 * i, 28 * i, 0));  // 56 m/s
    photos.push_back(At(60 * i, 400 * i, 0));
  }
  for (const auto& images : {fast, photos}) {
    const auto split = SplitExperience(images, {}, {});
    for (const ImageSubset& subset : split->subsets) {
      ASSERT_TRUE(subset.centre);
      for (const std::uint32_t i : subset.owned) {
        EXPECT_LE((images[i].position->coordinates() - subset.centre->coordinates()).norm(),
                  subset.radius_m + 1e-6);
      }
    }
  }
}

}  // namespace
}  // namespace waymark::mapping
