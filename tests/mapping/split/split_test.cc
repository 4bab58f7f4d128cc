// SPDX-License-Identifier: Apache-2.0
#include "mapping/split/split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "tests/mapping/split/drives.h"

namespace waymark::mapping {
namespace {

void ExpectLaws(const Split& split, std::span<const SplitImage> images,
                std::span<const ForeignImage> foreign, const SplitOptions& options) {
  std::multiset<std::uint32_t> seen(split.thinned_out.begin(), split.thinned_out.end());
  std::set<std::uint32_t> owned;
  for (const ImageSubset& subset : split.subsets) {
    seen.insert(subset.owned.begin(), subset.owned.end());
    owned.insert(subset.owned.begin(), subset.owned.end());
  }
  EXPECT_EQ(seen.size(), images.size()) << "owned once or thinned out";
  EXPECT_EQ(std::set(seen.begin(), seen.end()).size(), images.size());
  for (const ImageSubset& subset : split.subsets) {
    EXPECT_FALSE(subset.owned.empty());
    EXPECT_LE(subset.owned.size() + subset.neighbour.size() + subset.foreign.size(),
              static_cast<std::size_t>(options.max_images));
    if (subset.centre) {
      EXPECT_GE(subset.radius_m, options.min_radius_m);
      EXPECT_LE(subset.radius_m, options.max_radius_m);
    }
    const auto expect_inside = [&](const std::optional<Point<Map>>& position) {
      if (!position || !subset.centre) return;
      const Eigen::Vector3d offset = position->coordinates() - subset.centre->coordinates();
      EXPECT_LE(offset.head<2>().norm(), subset.radius_m + 1e-6);
    };
    for (const std::uint32_t i : subset.owned) expect_inside(images[i].position);
    for (const std::uint32_t i : subset.foreign) expect_inside(foreign[i].position);
    for (const std::uint32_t i : subset.neighbour) {
      expect_inside(images[i].position);
      EXPECT_TRUE(owned.contains(i)) << "a borrowed image is owned by somebody";
      EXPECT_FALSE(std::binary_search(subset.owned.begin(), subset.owned.end(), i));
    }
  }
}

TEST(Split, LawsHoldForRandomDrives) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const std::vector<SplitImage> images = Wander(400, 0.5 + 0.4 * seed, seed);
    std::vector<ForeignImage> foreign;
    for (std::size_t i = 0; i < images.size(); i += 2) {
      foreign.push_back({static_cast<std::uint32_t>(i % 3), images[i].position});
    }
    for (const int max_images : {1000, 60, 8}) {
      const SplitOptions options{.max_images = max_images, .seed = seed};
      const auto split = SplitExperience(images, foreign, options);
      ASSERT_TRUE(split.ok());
      ExpectLaws(*split, images, foreign, options);
    }
  }
}

TEST(Split, StreetGivesFiftyMetreSubsetsThatOverlapByTwenty) {
  const std::vector<SplitImage> images = Street(600, 0.5);
  const auto split = SplitExperience(images, {}, {});
  ASSERT_TRUE(split.ok());
  ASSERT_GE(split->subsets.size(), 19u);
  ASSERT_LE(split->subsets.size(), 21u);
  for (std::size_t i = 0; i + 1 < split->subsets.size(); ++i) {
    const ImageSubset& here = split->subsets[i];
    const ImageSubset& next = split->subsets[i + 1];
    if (i + 2 < split->subsets.size()) {
      EXPECT_NEAR(here.radius_m, 25, 0.5);
      EXPECT_NEAR((here.centre->coordinates() - next.centre->coordinates()).norm(), 30, 1.5);
    }
    std::vector<std::uint32_t> shared;
    std::set_intersection(here.neighbour.begin(), here.neighbour.end(), next.owned.begin(),
                          next.owned.end(), std::back_inserter(shared));
    EXPECT_GE(shared.size(), 15u) << "10 m of the neighbour, half a metre apart, in " << i;
  }
}

TEST(Split, SixtyMetreClipIsCutInTwoOverlappingHalves) {
  const std::vector<SplitImage> images = Street(60, 1.2);
  const auto split = SplitExperience(images, {}, {});
  ASSERT_TRUE(split.ok());
  ASSERT_EQ(split->subsets.size(), 2u);
  EXPECT_GE(split->subsets[0].neighbour.size(), 7u);
  EXPECT_GE(split->subsets[1].neighbour.size(), 7u);
}

TEST(Split, SmallerSubsetsOnRequest) {
  const std::vector<SplitImage> images = Street(60, 1.2);
  const SplitOptions options{.radius_m = 15, .min_radius_m = 10, .overlap_m = 10, .min_images = 5};
  const auto split = SplitExperience(images, {}, options);
  ASSERT_TRUE(split.ok());
  EXPECT_EQ(split->subsets.size(), 3u);
  ExpectLaws(*split, images, {}, options);
}

TEST(Split, DensePlaceIsThinnedOut) {
  std::vector<SplitImage> images;
  for (int i = 0; i < 3000; ++i) images.push_back(At(i, 0.001 * i, 0));
  const SplitOptions options;
  const auto split = SplitExperience(images, {}, options);
  ASSERT_TRUE(split.ok());
  ASSERT_EQ(split->subsets.size(), 1u);
  EXPECT_EQ(split->subsets[0].owned.size(), 1000u);
  EXPECT_EQ(split->thinned_out.size(), 2000u);
  ExpectLaws(*split, images, {}, options);
}

TEST(Split, DenseStreetIsCutSmallerBeforeItIsThinnedOut) {
  const std::vector<SplitImage> images = Street(200, 0.047);  // 1,064 images on 50 m
  const auto split = SplitExperience(images, {}, {});
  ASSERT_TRUE(split.ok());
  EXPECT_TRUE(split->thinned_out.empty());
  EXPECT_LT(split->subsets[1].radius_m, 24);
}

TEST(Split, SparsePhotosMakeOneLargerSubset) {
  const std::vector<SplitImage> images = Street(170, 6);
  const auto split = SplitExperience(images, {}, {});
  ASSERT_TRUE(split.ok());
  EXPECT_EQ(split->subsets.size(), 1u);
}

TEST(Split, SparseNeighboursShareImagesToo) {
  const std::vector<SplitImage> images = Street(400, 9);
  const SplitOptions options;
  const auto split = SplitExperience(images, {}, options);
  ASSERT_TRUE(split.ok());
  ASSERT_GE(split->subsets.size(), 2u);
  for (const ImageSubset& subset : split->subsets) EXPECT_GE(subset.neighbour.size(), 3u);
  ExpectLaws(*split, images, {}, options);
}

TEST(Split, BorrowsFromEveryOtherExperienceAtThePlace) {
  const std::vector<SplitImage> images = Street(40, 1);
  std::vector<ForeignImage> foreign;
  for (std::uint32_t i = 0; i < 400; ++i) foreign.push_back({0, Point<Map>(0.1 * i, 0.1 * i, 0)});
  for (std::uint32_t i = 0; i < 5; ++i) foreign.push_back({1, Point<Map>(i, i, 0)});
  foreign.push_back({2, Point<Map>(5000, 0, 0)});
  const auto split = SplitExperience(images, foreign, {});
  ASSERT_TRUE(split.ok());
  ASSERT_EQ(split->subsets.size(), 1u);
  const auto& borrowed = split->subsets[0].foreign;
  EXPECT_EQ(borrowed.size(), images.size());
  EXPECT_TRUE(std::ranges::count_if(borrowed, [](auto i) { return i >= 400 && i < 405; }) == 5);
  EXPECT_FALSE(std::ranges::count(borrowed, 405u)) << "five kilometres away";
}

TEST(Split, WithoutPositionsCutsTheSequenceIntoOverlappingWindows) {
  std::vector<SplitImage> images = Street(2500, 1);
  for (SplitImage& image : images) image.position.reset();
  const SplitOptions options;
  const auto split = SplitExperience(images, {}, options);
  ASSERT_TRUE(split.ok());
  EXPECT_EQ(split->subsets.size(), 5u);
  ExpectLaws(*split, images, {}, options);
  for (const ImageSubset& subset : split->subsets) EXPECT_GE(subset.neighbour.size(), 200u);
  EXPECT_EQ(SplitExperience(std::span(images).first(900), {}, options)->subsets.size(), 1u);
}

TEST(Split, IsDeterministicAndSeeded) {
  const std::vector<SplitImage> images = Wander(500, 0.2, 5);
  const SplitOptions options{.max_images = 40};
  const SplitOptions other{.max_images = 40, .seed = 2};
  const std::string once = Describe(*SplitExperience(images, {}, options));
  EXPECT_EQ(once, Describe(*SplitExperience(images, {}, options)));
  EXPECT_NE(once, Describe(*SplitExperience(images, {}, other)));
}

TEST(Split, RefusesWrongOptionsAndNoImages) {
  const std::vector<SplitImage> images = Street(10, 1);
  EXPECT_EQ(SplitExperience({}, {}, {}).error().code, ErrorCode::kInvalidArgument);
  for (const SplitOptions& wrong :
       {SplitOptions{.max_images = 3}, SplitOptions{.radius_m = 5}, SplitOptions{.min_radius_m = 0},
        SplitOptions{.overlap_m = 41}, SplitOptions{.min_images = 0},
        SplitOptions{.max_radius_m = 10}, SplitOptions{.neighbour_share = 0.9}}) {
    EXPECT_FALSE(SplitExperience(images, {}, wrong).ok());
  }
}

}  // namespace
}  // namespace waymark::mapping
