// SPDX-License-Identifier: Apache-2.0
// What of phones' questions is kept, where, and what comes back.
#include "session/rehearsal/kept_query.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "mapping/base/file.h"
#include "session/rehearsal/query_keeper.h"
#include "tests/localiser/map_on_disk.h"

namespace waymark::session {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::SizeIs;

LocaliseQuery Query(std::vector<std::uint8_t> image = {1, 2, 3, 10, 4}) {
  const std::array<double, 4> parameters{300.25, 300, 160, 120.125};
  return {.ticket = {},
          .request = {},
          .time = {},
          .camera = *CameraModel::Create(CameraKind::kPinhole, 320, 240, parameters),
          .prior = GeoPrior{{Angle::Degrees(37.7700001), Angle::Degrees(-122.4199), 12.5}, 8},
          .up_in_camera = Eigen::Vector3d(0.6, -0.8, 0),
          .image = std::move(image)};
}

localiser::Localisation AnswerAt(const Eigen::Vector3d& place) {
  localiser::Localisation answer;
  answer.pose = localiser::LocalisedPose{
      .map_from_camera = Transform<Map, Camera>(Eigen::Quaterniond::Identity(), place),
      .covariance = Eigen::Matrix<double, 6, 6>::Identity(),
      .submap = SubmapId("a"),
      .submap_from_camera = {}};
  return answer;
}

class KeptQueries : public testing::Test {
 protected:
  KeptQueries() : folder_(disk_.map().folder().parent_path() / "queries") {}

  std::shared_ptr<QueryKeeper> Open(double interval_s = 60, std::size_t max_cells = 100) {
    return *QueryKeeper::Open({.folder = folder_,
                               .per_cell = 3,
                               .max_cells = max_cells,
                               .min_interval = std::chrono::duration<double>(interval_s)},
                              disk_.map().description());
  }

  /// The first byte of each.
  std::vector<int> KeptImages() const {
    const auto files = ListKeptQueries(folder_);
    EXPECT_TRUE(files.ok()) << ToString(files.error());
    std::vector<int> images;
    for (const fs::path& file : *files) {
      const auto query = LoadKeptQuery(file);
      EXPECT_TRUE(query.ok()) << ToString(query.error());
      images.push_back(query->image.front());
    }
    return images;
  }

  localiser::MapOnDisk disk_;
  fs::path folder_;
};

TEST_F(KeptQueries, ComeBackAsTheyWereAsked) {
  const LocaliseQuery query = Query();
  const auto back = DecodeKeptQuery(EncodeKeptQuery(query), "q");
  ASSERT_TRUE(back.ok()) << ToString(back.error());
  EXPECT_EQ(back->camera, query.camera);
  EXPECT_EQ(back->prior->position.latitude.radians(), query.prior->position.latitude.radians());
  EXPECT_EQ(back->prior->sigma_m, 8);
  EXPECT_EQ(*back->up_in_camera, *query.up_in_camera);
  EXPECT_EQ(back->image, query.image);
  LocaliseQuery bare = query;
  bare.prior.reset();
  bare.up_in_camera.reset();
  const auto bare_back = DecodeKeptQuery(EncodeKeptQuery(bare), "q");
  ASSERT_TRUE(bare_back.ok());
  EXPECT_FALSE(bare_back->prior || bare_back->up_in_camera);
}

TEST_F(KeptQueries, ThatAreDamagedAreRefusedByName) {
  const auto bytes = EncodeKeptQuery(Query());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const auto cut = DecodeKeptQuery(std::span(bytes).first(length), "0_0/001.query");
    ASSERT_FALSE(cut.ok()) << length;
    EXPECT_THAT(cut.error().message, HasSubstr("0_0/001.query"));
  }
  int refused = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    auto damaged = bytes;
    damaged[i] ^= 0x15;
    const auto back = DecodeKeptQuery(damaged, "q");
    refused += back.ok() ? 0 : 1;  // a digit of a number may become another
  }
  EXPECT_GT(refused, static_cast<int>(bytes.size()) / 2);
}

TEST_F(KeptQueries, AreTheNewestFewOfEachPlace) {
  {
    const auto keeper = Open(0);
    for (std::uint8_t i = 0; i < 5; ++i) keeper->Keep(Query({i}), AnswerAt({10, 10, 0}));
    keeper->Keep(Query({99}), AnswerAt({-10, 310, 0}));
  }
  EXPECT_THAT(*ListFolder(folder_ / "0_0"), SizeIs(3));
  EXPECT_THAT(*ListFolder(folder_ / "-1_6"), SizeIs(1));
  EXPECT_THAT(KeptImages(), testing::UnorderedElementsAre(99, 2, 3, 4));
}

TEST_F(KeptQueries, OfAFullPlaceAreRareAndGoOnAfterARestart) {
  Open()->Keep(Query({1}), AnswerAt({10, 10, 0}));
  Open()->Keep(Query({2}), AnswerAt({10, 10, 0}));
  Open()->Keep(Query({3}), AnswerAt({10, 10, 0}));
  EXPECT_THAT(KeptImages(), SizeIs(3));
  {
    const auto keeper = Open(1000);
    keeper->Keep(Query({4}), AnswerAt({10, 10, 0}));
    keeper->Keep(Query({5}), AnswerAt({10, 10, 0}));
  }
  EXPECT_THAT(KeptImages(), testing::UnorderedElementsAre(4, 2, 3));
}

TEST_F(KeptQueries, ThatNobodyCanPlaceAreNotKeptNorThoseBeyondTheLimit) {
  {
    const auto keeper = Open(0, 1);
    LocaliseQuery lost = Query();
    lost.prior.reset();
    keeper->Keep(lost, {});
    keeper->Keep(Query({1}), {});  // its prior says where
    keeper->Keep(Query({2}), AnswerAt({500, 0, 0}));
  }
  EXPECT_THAT(KeptImages(), SizeIs(1));
}

TEST_F(KeptQueries, AFailingDiskNeverKeepsAnAnswerBack) {
  const auto keeper = Open(0);
  fs::remove_all(folder_);
  ASSERT_TRUE(StoreFileAtomically(folder_, "in the way").ok());
  const auto answer = Observed(
      [](const LocaliseQuery&) {
        return AnswerAt({1, 1, 0});
      },
      keeper)(Query());
  EXPECT_TRUE(answer.ok() && answer->pose);
}

}  // namespace
}  // namespace waymark::session
