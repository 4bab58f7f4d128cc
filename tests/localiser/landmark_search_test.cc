// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/landmark_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "localiser/internal/coarse_quantiser.h"
#include "tests/localiser/random_place.h"

namespace waymark::localiser::internal {
namespace {

struct Database {
  std::vector<mapping::Descriptor> descriptors;
  std::vector<std::uint32_t> landmarks;
};

Database MakeDatabase(int landmarks, std::uint64_t seed) {
  Database database;
  for (const auto& seen : RandomPlace({.landmarks = landmarks}, seed).Model().observations) {
    database.descriptors.push_back(seen.descriptor);
    database.landmarks.push_back(seen.landmark);
  }
  return database;
}

/// The definition, one landmark after the other.
std::vector<LandmarkMatch> MatchByDefinition(const Database& database,
                                             std::span<const mapping::Descriptor> features,
                                             const LandmarkSearchOptions& options) {
  std::vector<LandmarkMatch> matches;
  for (std::uint32_t f = 0; f < features.size(); ++f) {
    std::map<std::uint32_t, std::int32_t> best_of;
    for (std::size_t e = 0; e < database.descriptors.size(); ++e) {
      std::int32_t dot = 0;
      for (int k = 0; k < 128; ++k) dot += features[f][k] * database.descriptors[e][k];
      auto& best = best_of.emplace(database.landmarks[e], -1).first->second;
      best = std::max(best, dot);
    }
    std::vector<std::pair<std::int32_t, std::uint32_t>> ranking;
    for (const auto& [landmark, dot] : best_of) ranking.emplace_back(-dot, landmark);
    std::sort(ranking.begin(), ranking.end());
    const double first = mapping::DescriptorAngle(-ranking[0].first);
    const double second = mapping::DescriptorAngle(-ranking[1].first);
    if (first > options.max_angle_rad || first / second >= options.max_ratio) continue;
    matches.push_back({f, ranking[0].second, static_cast<float>(first / second)});
  }
  return matches;
}

class LandmarkSearchTest : public testing::Test {
 protected:
  LandmarkSearchTest() {
    const mapping::ImageFeatures photo = place_.Photo(place_.Viewpoint(0), 100);
    features_ = photo.descriptors;
  }

  RandomPlace place_{{.landmarks = 900}, 5};
  Database database_ = MakeDatabase(900, 5);
  std::vector<mapping::Descriptor> features_;
};

TEST_F(LandmarkSearchTest, WholeScanIsTheRatioTestAgainstAnotherLandmarkByDefinition) {
  const LandmarkSearchOptions options{.entries_per_cell = 100};
  const LandmarkSearch search(database_.descriptors, database_.landmarks, options);
  const auto expected = MatchByDefinition(database_, features_, options);
  EXPECT_GT(expected.size(), 100u);
  EXPECT_EQ(search.Match(features_), expected);
}

TEST_F(LandmarkSearchTest, ListsThatAreAllVisitedGiveTheSameAnswer) {
  const LandmarkSearchOptions options{
      .exhaustive_below = 0, .entries_per_cell = 100, .probes = 1000};
  const LandmarkSearch search(database_.descriptors, database_.landmarks, options);
  EXPECT_EQ(search.Match(features_), MatchByDefinition(database_, features_, options));
}

TEST_F(LandmarkSearchTest, AFewListsAreEnoughForNearlyAllMatches) {
  const LandmarkSearchOptions options{.exhaustive_below = 0, .entries_per_cell = 64, .probes = 8};
  const LandmarkSearch search(database_.descriptors, database_.landmarks, options);
  const auto expected = MatchByDefinition(database_, features_, options);
  const auto found = search.Match(features_);
  std::size_t common = 0;
  for (const LandmarkMatch& match : found) {
    common += std::count_if(expected.begin(), expected.end(), [&](const LandmarkMatch& e) {
      return e.feature == match.feature && e.landmark == match.landmark;
    });
  }
  EXPECT_GT(static_cast<double>(common), 0.9 * static_cast<double>(expected.size()));
}

TEST_F(LandmarkSearchTest, TheSameSeedGivesTheSameMatches) {
  const LandmarkSearchOptions options{.exhaustive_below = 0, .entries_per_cell = 64};
  const LandmarkSearch a(database_.descriptors, database_.landmarks, options);
  const LandmarkSearch b(database_.descriptors, database_.landmarks, options);
  EXPECT_EQ(a.Match(features_), b.Match(features_));
}

TEST_F(LandmarkSearchTest, TwoLandmarksThatLookTheSameMatchNothing) {
  Database doubled = database_;
  for (std::size_t i = 0; i < database_.descriptors.size(); ++i) {
    doubled.descriptors.push_back(database_.descriptors[i]);
    doubled.landmarks.push_back(database_.landmarks[i] + 900);
  }
  const LandmarkSearch search(doubled.descriptors, doubled.landmarks, {});
  EXPECT_TRUE(search.Match(features_).empty());
}

TEST(LandmarkSearch, EmptySidesMatchNothing) {
  const LandmarkSearch empty({}, {}, {});
  const std::vector<mapping::Descriptor> features(3);
  EXPECT_TRUE(empty.Match(features).empty());
  EXPECT_TRUE(empty.Match({}).empty());
  const Database database = MakeDatabase(20, 1);
  const LandmarkSearch search(database.descriptors, database.landmarks, {});
  EXPECT_TRUE(search.Match({}).empty());
  EXPECT_TRUE(search.Match(features).empty()) << "black descriptors are similar to nothing";
}

TEST(CoarseQuantiser, GivesAtMostAsManyRepresentativesAsAskedAlsoForEqualDescriptors) {
  const std::vector<mapping::Descriptor> equal(500, RandomPlace(1).RandomDescriptor());
  const auto representatives = TrainCoarseQuantiser(equal, 16, 1);
  EXPECT_GE(representatives.size(), 1u);
  EXPECT_LE(representatives.size(), 16u);
  EXPECT_EQ(TrainCoarseQuantiser(std::vector(1, equal[0]), 4, 1).size(), 1u);
}

}  // namespace
}  // namespace waymark::localiser::internal
