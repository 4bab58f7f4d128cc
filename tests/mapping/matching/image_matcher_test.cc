// SPDX-License-Identifier: Apache-2.0
#include "mapping/matching/image_matcher.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/mapping/matching/random_descriptors.h"

namespace waymark::mapping {
namespace {

using testing::IsEmpty;

constexpr SearchOptions kAlwaysInCells{.exhaustive_below = 0};

/// Two images that share every third descriptor of the first, disturbed and in another order.
struct Views {
  explicit Views(std::size_t count) {
    std::mt19937 random(5);
    images = {RandomRootSift(count, random), RandomRootSift(count, random)};
    for (std::uint32_t i = 0; i < count; i += 3) {
      planted.push_back({i, static_cast<std::uint32_t>(count - 1 - i)});
      images[1][planted.back().second] = Disturbed(images[0][i], 8, random);
    }
  }

  ImageMatcher Matcher(const SearchOptions& search, int threads = 1) const {
    return ImageMatcher({images.begin(), images.end()}, {}, search, {.threads = threads});
  }

  std::vector<std::vector<Descriptor>> images;
  std::vector<FeatureMatch> planted;
};

TEST(ImageMatcher, FewFeaturesAreSearchedWhole) {
  const Views views(900);
  EXPECT_EQ(views.Matcher({.exhaustive_below = 901}).Match({0, 1}),
            MatchDescriptors(views.images[0], views.images[1], {}));
}

TEST(ImageMatcher, FindsNearlyAllInCellsAndNothingElse) {
  const Views views(3000);
  const auto found = views.Matcher(kAlwaysInCells).Match({0, 1});
  EXPECT_GT(found.size(), 0.97 * static_cast<double>(views.planted.size()));
  EXPECT_TRUE(std::ranges::includes(views.planted, found));
  EXPECT_TRUE(std::ranges::is_sorted(found));
}

TEST(ImageMatcher, MoreProbesFindMore) {
  const Views views(3000);
  const auto count = [&](int probes) {
    return views.Matcher({.exhaustive_below = 0, .probes = probes}).Match({0, 1}).size();
  };
  EXPECT_LT(count(1), count(4));
  EXPECT_LE(count(4), count(8));
}

TEST(ImageMatcher, TheOrderOfTheImagesDoesNotMatter) {
  const Views views(2000);
  const ImageMatcher matcher = views.Matcher({.exhaustive_below = 0, .probes = 8});
  auto backward = matcher.Match({1, 0});
  for (FeatureMatch& match : backward) std::swap(match.first, match.second);
  std::ranges::sort(backward);
  const auto forward = matcher.Match({0, 1});
  std::vector<FeatureMatch> both;
  std::ranges::set_intersection(forward, backward, std::back_inserter(both));
  EXPECT_GT(both.size(), 0.98 * static_cast<double>(forward.size()));
}

TEST(ImageMatcher, IsTheSameOnAnyNumberOfThreads) {
  const Views views(2000);
  const auto one = views.Matcher(kAlwaysInCells, 1).Match({0, 1});
  EXPECT_EQ(views.Matcher(kAlwaysInCells, 3).Match({0, 1}), one);
  std::srand(99);
  EXPECT_EQ(views.Matcher(kAlwaysInCells, 2).Match({0, 1}), one) << "nor does who drew before";
}

TEST(ImageMatcher, MostAmbiguousOnesAreLeftOutInCellsToo) {
  Views views(1000);
  std::mt19937 random(7);
  for (std::size_t i = 0; i < 300; i += 3) {  // two of each, in places where nothing was planted
    views.images[1][i + 1] = Disturbed(views.images[0][i + 1], 4, random);
    views.images[1][i + 2] = Disturbed(views.images[0][i + 1], 4, random);
  }
  // The other of the two may lie in a cell that is not visited.
  const auto found = views.Matcher(kAlwaysInCells).Match({0, 1});
  EXPECT_LT(std::ranges::count_if(found, [](const auto& match) { return match.first % 3 == 1; }),
            15);
}

TEST(ImageMatcher, ImagesWithoutFeaturesAreHarmless) {
  const Views views(1000);
  const std::vector<Descriptor> none;
  const ImageMatcher matcher({views.images[0], none, views.images[1]}, {}, kAlwaysInCells, {});
  EXPECT_THAT(matcher.Match({0, 1}), IsEmpty());
  EXPECT_THAT(matcher.Match({1, 2}), IsEmpty());
  EXPECT_THAT(matcher.Match({0, 2}), testing::Not(IsEmpty()));
  EXPECT_THAT(ImageMatcher({none, none}, {}, kAlwaysInCells, {}).Match({0, 1}), IsEmpty());
}

TEST(SearchOptions, RefusesWhatIsOutOfRange) {
  EXPECT_TRUE(SearchOptions{}.Validate().ok());
  EXPECT_FALSE(SearchOptions{.exhaustive_below = -1}.Validate().ok());
  EXPECT_FALSE(SearchOptions{.cells = 8}.Validate().ok());
  EXPECT_FALSE(SearchOptions{.probes = 0}.Validate().ok());
  EXPECT_FALSE(SearchOptions{.probes = 17}.Validate().ok());
}

}  // namespace
}  // namespace waymark::mapping
