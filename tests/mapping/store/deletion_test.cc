// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <fstream>

#include "mapping/store/map_directory.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Deletion : public testing::Test {
 protected:
  Deletion()
      : folder_(fs::path(testing::TempDir()) /
                (std::string("deletion.") +
                 testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(folder_);
    map_ = MapDirectory::Create(folder_, {"5f0c1a52-52ac-4a3c-9f3a-0d6b8a2f7c11", {}, false, "{}"})
               .value();
  }
  ~Deletion() override { fs::remove_all(folder_); }

  const MapDirectory& Map() const { return *map_; }

  /// An empty release.
  void Store(std::uint64_t epoch) const {
    Release release;
    release.epoch = epoch;
    ASSERT_TRUE(Map().StoreRelease(release));
  }

  void MakeExperience(const std::string& name) const {
    fs::create_directories(folder_ / "experiences" / name / "features");
    std::ofstream(folder_ / "experiences" / name / "features" / "a.feat") << "x";
  }

  fs::path folder_;
  std::optional<MapDirectory> map_;
};

TEST_F(Deletion, OldReleasesGoButNotTheLiveAndTheNewest) {
  for (const std::uint64_t epoch : {1, 2, 3}) Store(epoch);
  ASSERT_TRUE(Map().Deploy(2));
  EXPECT_TRUE(Map().DeleteRelease(1));
  EXPECT_TRUE(Map().DeleteRelease(1)) << "again";
  const auto live = Map().DeleteRelease(2);
  ASSERT_FALSE(live);
  EXPECT_EQ(live.error().code, ErrorCode::kConflict);
  EXPECT_THAT(live.error().message, HasSubstr("epoch 2 is the live release"));
  EXPECT_EQ(Map().DeleteRelease(3).error().code, ErrorCode::kConflict);
  EXPECT_THAT(Map().ListReleaseEpochs().value(), ElementsAre(2, 3));
}

TEST_F(Deletion, SubmapsAreListedAndDeleted) {
  EXPECT_THAT(Map().ListSubmaps().value(), IsEmpty());
  const SubmapId first = Map().StoreSubmap(std::vector<std::uint8_t>{1}).value();
  const SubmapId second = Map().StoreSubmap(std::vector<std::uint8_t>{2}).value();
  std::ofstream(folder_ / "submaps" / ".ab.17.0.tmp") << "half a submap";
  EXPECT_THAT(Map().ListSubmaps().value(), testing::UnorderedElementsAre(first, second));
  EXPECT_TRUE(Map().DeleteSubmap(first));
  EXPECT_TRUE(Map().DeleteSubmap(first)) << "again";
  EXPECT_THAT(Map().ListSubmaps().value(), ElementsAre(second));
}

TEST_F(Deletion, ExperiencesGoWhole) {
  MakeExperience("monday");
  MakeExperience("tuesday");
  EXPECT_TRUE(Map().DeleteExperience(ExperienceId("monday")));
  EXPECT_TRUE(Map().DeleteExperience(ExperienceId("monday"))) << "again";
  EXPECT_THAT(Map().ListExperiences().value(), ElementsAre(ExperienceId("tuesday")));
}

TEST_F(Deletion, ADeletionThatWasCutShortIsInvisibleAndFinished) {
  MakeExperience(".deleted.monday");
  EXPECT_THAT(Map().ListExperiences().value(), IsEmpty());
  MakeExperience("monday");
  EXPECT_TRUE(Map().DeleteExperience(ExperienceId("monday")));
  EXPECT_TRUE(fs::is_empty(folder_ / "experiences"));
  MakeExperience(".deleted.monday");
  EXPECT_TRUE(Map().FinishDeletions());
  EXPECT_TRUE(fs::is_empty(folder_ / "experiences"));
}

}  // namespace
}  // namespace waymark::mapping
