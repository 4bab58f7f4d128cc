// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/landmark_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <numeric>
#include <tuple>
#include <vector>

#include "localiser/internal/coarse_quantiser.h"
#include "localiser/internal/kd_tree_search.h"
#include "mapping/matching/descriptor_matching.h"
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

constexpr LandmarkSearchOptions kWithLists{.exhaustive_below = 0};

CoarseQuantiser Train(const Database& database, std::size_t cells, std::uint64_t seed = 1) {
  const std::array sets{std::span<const mapping::Descriptor>(database.descriptors)};
  return CoarseQuantiser::Train(sets, cells, seed);
}

std::vector<LandmarkMatch> Match(const Database& database,
                                 std::span<const mapping::Descriptor> features,
                                 const CoarseQuantiser& quantiser, std::size_t probes,
                                 const LandmarkSearchOptions& options) {
  const LandmarkSearch search(database.descriptors, database.landmarks, quantiser, options);
  return search.Match(features, quantiser.Rank(features, probes)).matches;
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
  const LandmarkSearchOptions options;
  const auto expected = MatchByDefinition(database_, features_, options);
  EXPECT_GT(expected.size(), 100u);
  EXPECT_EQ(Match(database_, features_, Train(database_, 1), 1, options), expected);
}

TEST_F(LandmarkSearchTest, ListsThatAreAllVisitedGiveTheSameAnswer) {
  EXPECT_EQ(Match(database_, features_, Train(database_, 30), 1000, kWithLists),
            MatchByDefinition(database_, features_, kWithLists));
}

TEST_F(LandmarkSearchTest, AFewListsAreEnoughForNearlyAllMatches) {
  const auto expected = MatchByDefinition(database_, features_, kWithLists);
  const auto found = Match(database_, features_, Train(database_, 40), 8, kWithLists);
  std::size_t common = 0;
  for (const LandmarkMatch& match : found) {
    common += std::count_if(expected.begin(), expected.end(), [&](const LandmarkMatch& e) {
      return e.feature == match.feature && e.landmark == match.landmark;
    });
  }
  EXPECT_GT(static_cast<double>(common), 0.9 * static_cast<double>(expected.size()));
}

TEST_F(LandmarkSearchTest, KdTreesThatLookEverywhereFindTheSameButForNearTies) {
  const auto expected = MatchByDefinition(database_, features_, {});
  const KdTreeSearch everywhere(database_.descriptors, database_.landmarks, {},
                                {.trees = 1, .checks = -1});
  const auto found = everywhere.Match(features_).matches;
  std::size_t common = 0;
  for (const LandmarkMatch& match : found) {
    common += std::count_if(expected.begin(), expected.end(), [&](const LandmarkMatch& e) {
      return e.feature == match.feature && e.landmark == match.landmark;
    });
  }
  EXPECT_GT(static_cast<double>(common), 0.97 * static_cast<double>(expected.size()));
  EXPECT_GT(static_cast<double>(common), 0.97 * static_cast<double>(found.size()));
  EXPECT_TRUE(std::ranges::is_sorted(found));
  EXPECT_TRUE(KdTreeSearch({}, {}, {}).Match(features_).matches.empty());
}

TEST_F(LandmarkSearchTest, TheSameSeedGivesTheSameMatches) {
  EXPECT_EQ(Match(database_, features_, Train(database_, 40), 4, kWithLists),
            Match(database_, features_, Train(database_, 40), 4, kWithLists));
}

TEST_F(LandmarkSearchTest, TwoLandmarksThatLookTheSameMatchNothing) {
  Database doubled = database_;
  for (std::size_t i = 0; i < database_.descriptors.size(); ++i) {
    doubled.descriptors.push_back(database_.descriptors[i]);
    doubled.landmarks.push_back(database_.landmarks[i] + 900);
  }
  EXPECT_TRUE(Match(doubled, features_, Train(doubled, 4), 4, {}).empty());
}

TEST_F(LandmarkSearchTest, ResemblancesHoldBothOfTwoCopies) {
  Database doubled = database_;
  const auto count = static_cast<std::uint32_t>(database_.landmarks.size());
  for (std::size_t i = 0; i < database_.descriptors.size(); ++i) {
    doubled.descriptors.push_back(database_.descriptors[i]);
    doubled.landmarks.push_back(database_.landmarks[i] + count);
  }
  const auto matches = MatchByDefinition(database_, features_, {});
  const CoarseQuantiser quantiser = Train(doubled, 4);
  const LandmarkSearch search(doubled.descriptors, doubled.landmarks, quantiser, {});
  const auto found = search.Match(features_, quantiser.Rank(features_, 4)).resemblances;
  EXPECT_TRUE(std::is_sorted(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::tie(a.feature, b.dot) < std::tie(b.feature, a.dot);
  }));
  std::size_t both = 0;
  for (const LandmarkMatch& match : matches) {
    const auto holds = [&](std::uint32_t landmark) {
      return std::any_of(found.begin(), found.end(), [&](const Resemblance& r) {
        return r.feature == match.feature && r.landmark == landmark;
      });
    };
    both += holds(match.landmark) && holds(match.landmark + count);
  }
  // Copies that share a lane hide each other: one in sixteen.
  EXPECT_GT(static_cast<double>(both), 0.85 * static_cast<double>(matches.size()));
}

TEST(LandmarkSearch, EmptySidesMatchNothing) {
  const Database database = MakeDatabase(20, 1);
  const CoarseQuantiser quantiser = Train(database, 2);
  const std::vector<mapping::Descriptor> features(3);
  for (const LandmarkSearchOptions& options : {LandmarkSearchOptions{}, kWithLists}) {
    EXPECT_TRUE(Match({}, features, quantiser, 2, options).empty());
    EXPECT_TRUE(Match(database, {}, quantiser, 2, options).empty());
    EXPECT_TRUE(Match(database, features, quantiser, 2, options).empty())
        << "black descriptors are similar to nothing";
  }
}

TEST(CoarseQuantiser, GivesAtMostAsManyCellsAsAskedAlsoForEqualDescriptors) {
  Database equal;
  equal.descriptors.assign(500, RandomPlace(1).RandomDescriptor());
  const CoarseQuantiser quantiser = Train(equal, 16);
  EXPECT_GE(quantiser.size(), 1u);
  EXPECT_LE(quantiser.size(), 16u);
  equal.descriptors.resize(1);
  EXPECT_EQ(Train(equal, 4).size(), 1u);
}

TEST(CoarseQuantiser, RanksByDotProductAndAssignsTheBest) {
  const Database database = MakeDatabase(200, 3);
  const CoarseQuantiser quantiser = Train(database, 25);
  const auto assigned = quantiser.Assign(database.descriptors);
  const RankedCells some = quantiser.Rank(database.descriptors, 3);
  const RankedCells all = quantiser.Rank(database.descriptors, 1000);
  EXPECT_EQ(all.per_feature, quantiser.size());
  for (std::size_t i = 0; i < database.descriptors.size(); ++i) {
    EXPECT_EQ(some.Of(i)[0], assigned[i]);
    EXPECT_TRUE(std::ranges::equal(some.Of(i), all.Of(i).first(3)));
  }
}

TEST(CoarseQuantiser, TrainsOnAllSets) {
  const Database a = MakeDatabase(50, 1), b = MakeDatabase(70, 2);
  const std::array<std::span<const mapping::Descriptor>, 4> sets{
      std::span<const mapping::Descriptor>(), a.descriptors, {}, b.descriptors};
  EXPECT_GT(CoarseQuantiser::Train(sets, 10, 1).size(), 5u);
}

TEST(CoarseQuantiser, FeaturesAreTheVisitorsOfTheirCells) {
  const Database database = MakeDatabase(200, 3);
  const RankedCells ranked = Train(database, 25).Rank(database.descriptors, 3);
  std::size_t visits = 0;
  for (std::size_t cell = 0; cell + 1 < ranked.visitor_begins.size(); ++cell) {
    for (const std::uint32_t feature : ranked.VisitorsOf(cell)) {
      EXPECT_NE(std::ranges::find(ranked.Of(feature), cell), ranked.Of(feature).end());
      ++visits;
    }
  }
  EXPECT_EQ(visits, 3 * database.descriptors.size());
}

TEST(CoarseQuantiser, RanksManyCellsAsFewOnes) {
  const std::vector<mapping::Descriptor> centres = MakeDatabase(300, 3).descriptors;
  const std::vector<mapping::Descriptor> features = MakeDatabase(20, 4).descriptors;
  const CoarseQuantiser quantiser(centres);
  const RankedCells some = quantiser.Rank(features, 16);
  const RankedCells all = quantiser.Rank(features, centres.size());
  for (std::size_t f = 0; f < features.size(); ++f) {
    EXPECT_TRUE(std::ranges::equal(some.Of(f), all.Of(f).first(16)));
  }
}

}  // namespace
}  // namespace waymark::localiser::internal
