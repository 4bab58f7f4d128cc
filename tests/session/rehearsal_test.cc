// SPDX-License-Identifier: Apache-2.0
// What speaks against a release, and the program that asks.
#include "session/rehearsal/rehearsal_report.h"

#include <gmock/gmock.h>

#include <cstdlib>

#include "mapping/base/file.h"
#include "mapping/features/feature_codec.h"
#include "session/rehearsal/kept_query.h"
#include "tests/localiser/localiser_fixture.h"

namespace waymark::session {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<ReplayedQuery> Same(std::size_t count, MapCell cell = {}) {
  return std::vector<ReplayedQuery>(count, {cell, true, true, 0.02});
}

TEST(JudgeRelease, HasNothingAgainstOneThatAnswersTheSame) {
  const RehearsalReport report = JudgeRelease(Same(100), AnchorMoves{.anchors = 5}, {});
  EXPECT_TRUE(report.HasPassed());
  EXPECT_EQ(report.all.in_candidate, 100u);
  EXPECT_NEAR(report.p95_apart_m, 0.02, 1e-12);
  EXPECT_THAT(DescribeRehearsal(report), HasSubstr("passed"));
}

TEST(JudgeRelease, CannotSayWithoutEnoughQuestions) {
  const RehearsalReport report = JudgeRelease(Same(19), std::nullopt, {});
  EXPECT_THAT(report.objections, ElementsAre(HasSubstr("at least 20")));
}

TEST(JudgeRelease, ObjectsWhereFewerAreAnswered) {
  auto queries = Same(1000);
  for (std::size_t i = 0; i < 11; ++i) queries[i].in_candidate = false;
  EXPECT_THAT(JudgeRelease(queries, {}, {}).objections, ElementsAre(HasSubstr("11 of 1000")));
  for (std::size_t i = 0; i < 11; ++i) queries.push_back({{}, false, true, 0});
  EXPECT_TRUE(JudgeRelease(queries, {}, {}).HasPassed()) << "as many are answered anew";
}

TEST(JudgeRelease, ObjectsToOneStreetThatIsLostAmongManyThatAreNot) {
  auto queries = Same(1000);
  auto corner = Same(5, {3, -2});
  corner[0].in_candidate = corner[1].in_candidate = false;
  queries.insert(queries.end(), corner.begin(), corner.end());
  EXPECT_THAT(JudgeRelease(queries, {}, {}).objections,
              ElementsAre(HasSubstr("around 175 m east, -75 m north 2 of 5")));
}

TEST(JudgeRelease, ObjectsToAnswersThatLieElsewhere) {
  auto queries = Same(100);
  queries[0].apart_m = queries[1].apart_m = 30;
  EXPECT_THAT(JudgeRelease(queries, {}, {}).objections, ElementsAre(HasSubstr("2 of 100")));
}

TEST(JudgeRelease, ObjectsToAnchorsThatMoveOrLoseAllSubmaps) {
  const AnchorMoves moves{.anchors = 9, .beyond_limit = 2, .losing_support = 1};
  EXPECT_THAT(JudgeRelease(Same(100), moves, {}).objections,
              ElementsAre(HasSubstr("2 of 9 anchors move"), HasSubstr("1 of 9 anchors lose")));
  EXPECT_THAT(EncodeRehearsal(JudgeRelease(Same(100), moves, {})), HasSubstr("\"passed\": false"));
}

/// A map whose live release shows a place, and the program as a user runs it.
class RehearseProgram : public localiser::LocaliserTest {
 protected:
  void SetUp() override {
    place_submap_ = disk_.Add(place_.Model(), localiser::kMapFromSubmap);
    other_submap_ = disk_.Add(localiser::RandomPlace(2).Model(),
                              Sim3(1, Eigen::Quaterniond::Identity(), {500, 0, 0}));
    Store(1, {});
    ASSERT_TRUE(disk_.map().Deploy(1).ok());
    for (int i = 0; i < 24; ++i) Keep(i);
  }

  /// The release without these submaps.
  void Store(std::uint64_t epoch, const std::set<SubmapId>& without) {
    mapping::Release release = disk_.release();
    release.epoch = epoch;
    if (epoch > 1) release.parent_epoch = 1;
    release.created_utc = "2026-01-02T03:04:05Z";
    std::erase_if(release.submaps, [&](const auto& s) { return without.contains(s.id); });
    const auto stored = disk_.map().StoreRelease(release);
    ASSERT_TRUE(stored.ok()) << ToString(stored.error());
  }
  void Keep(int i) {
    const auto photo = place_.Photo(place_.Viewpoint(0.1 * i), 100);
    const LocaliseQuery query{.time = {},
                              .camera = localiser::TestCamera(),
                              .prior = {},
                              .up_in_camera = {},
                              .image = mapping::EncodeFeatures(photo)};
    ASSERT_TRUE(CreateFolders(Queries()).ok());
    ASSERT_TRUE(
        StoreFileAtomically(Queries() / fmt::format("{:03}.query", i), EncodeKeptQuery(query))
            .ok());
  }
  std::filesystem::path Queries() { return disk_.map().folder().parent_path() / "queries"; }
  int Run(const std::string& arguments) {
    const int status = std::system(fmt::format("{} {} {} > /dev/null 2>&1", WAYMARK_REHEARSE,
                                               disk_.map().folder().string(), arguments)
                                       .c_str());
    return WEXITSTATUS(status);
  }
  std::uint64_t LiveEpoch() { return **disk_.map().LoadCurrentEpoch(); }

  SubmapId place_submap_{""}, other_submap_{""};
};

TEST_F(RehearseProgram, DeploysWhatNothingSpeaksAgainst) {
  Store(2, {other_submap_});
  EXPECT_EQ(Run("2 --queries " + Queries().string()), 0);
  EXPECT_EQ(LiveEpoch(), 1u) << "it was not told to";
  EXPECT_EQ(Run("2 --deploy --queries " + Queries().string()), 0);
  EXPECT_EQ(LiveEpoch(), 2u);
}

TEST_F(RehearseProgram, KeepsTheLiveReleaseWhereAPlaceWouldBeLost) {
  Store(2, {place_submap_});
  EXPECT_EQ(Run("2 --deploy --queries " + Queries().string()), 3);
  EXPECT_EQ(LiveEpoch(), 1u);
}

TEST_F(RehearseProgram, SaysWhenItCannotKnow) {
  Store(2, {other_submap_});
  EXPECT_EQ(Run("2 --deploy --queries /nowhere"), 1);
  EXPECT_EQ(Run("7 --deploy --queries " + Queries().string()), 1);
  ASSERT_TRUE(StoreFileAtomically(Queries() / "damaged.query", "{}\n").ok());
  EXPECT_EQ(Run("2 --deploy --queries " + Queries().string()), 1);
  EXPECT_EQ(LiveEpoch(), 1u);
}

}  // namespace
}  // namespace waymark::session
