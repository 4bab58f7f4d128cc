// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/pruning.h"

#include <gmock/gmock.h>

#include <chrono>
#include <fstream>
#include <memory>

#include "mapping/store/release_diff.h"
#include "tests/mapping/pipeline/street_map.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// A drive that is cut into several submaps and one that stands alone.
class Pruning : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    street_ = std::make_unique<StreetMap>("pruning");
    street_->Drive("long", {.images = 14});
    street_->Drive("lone", {.images = 8, .first_m = 60, .seed = 2});
    ASSERT_TRUE(Add({"long", "lone"}, "original").ok());
    ASSERT_GE(street_->Live("original").count("long"), 2u);
  }
  static void TearDownTestSuite() { street_.reset(); }

  Pruning() {
    fs::remove_all(street_->MapFolder());
    fs::copy(street_->MapFolder("original"), street_->MapFolder(), fs::copy_options::recursive);
  }

  static Result<AddReport> Add(const std::vector<std::string>& drives,
                               const std::string& map = "map") {
    AddRequest request = street_->MakeAdd(drives, map);
    request.options.split =
        SplitOptions{.radius_m = 4, .min_radius_m = 3, .overlap_m = 3, .min_images = 4};
    return AddExperiences(request);
  }

  static PruneReport Prune(std::size_t keep) {
    return PruneMap({.map_folder = street_->MapFolder(), .keep = keep}).value();
  }

  /// Makes a file look as if its writer had died yesterday.
  static void Age(const fs::path& path) {
    fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(24));
  }

  static inline std::unique_ptr<StreetMap> street_;
};

TEST_F(Pruning, WhatIsLiveOrKeptStays) {
  const auto before = street_->Files();
  EXPECT_EQ(Prune(1).bytes, 0u);
  EXPECT_EQ(street_->Files(), before);
  ASSERT_TRUE(street_->Remove("lone").ok());
  EXPECT_THAT(Prune(2).submaps, IsEmpty()) << "the release before still holds it";
  ASSERT_TRUE(street_->Open().Deploy(1));
  EXPECT_THAT(Prune(1).releases, IsEmpty()) << "one is live, the other the newest";
}

TEST_F(Pruning, ARemovedExperienceGoesWithTheLastReleaseThatHoldsIt) {
  ASSERT_TRUE(street_->Remove("lone").ok());
  const PruneRequest rehearsal{street_->MapFolder(), 1, true};
  const auto files = street_->Files();
  EXPECT_THAT(PruneMap(rehearsal)->experiences, ElementsAre(ExperienceId("lone")));
  EXPECT_EQ(street_->Files(), files);
  const PruneReport report = Prune(1);
  EXPECT_THAT(report.releases, ElementsAre(1));
  EXPECT_THAT(report.submaps, SizeIs(1));
  EXPECT_THAT(report.experiences, ElementsAre(ExperienceId("lone")));
  EXPECT_THAT(street_->Open().ListExperiences().value(), ElementsAre(ExperienceId("long")));
  EXPECT_EQ(street_->Open().ListSubmaps()->size(), street_->Live().size());
  EXPECT_EQ(Prune(1).bytes, 0u);
  EXPECT_TRUE(Add({"lone"}).ok()) << "from the beginning";
  EXPECT_EQ(street_->Live(), street_->Live("original"));
}

TEST_F(Pruning, ASubmapOfAPartlyRemovedExperienceIsBuiltAgainWhenItIsAddedAgain) {
  RemoveRequest request = street_->MakeRemove();
  request.submaps.push_back(street_->Live().find("long")->second);
  ASSERT_TRUE(RemoveFromMap(request).ok());
  EXPECT_THAT(Prune(1).submaps, ElementsAre(request.submaps[0]));
  const auto report = Add({"long"});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->submaps,
              testing::Contains(testing::Field(&SubmapReport::was_built_before, false)));
  EXPECT_EQ(street_->Live(), street_->Live("original"));
}

TEST_F(Pruning, APlanThatBorrowsFromWhatIsGoneIsMadeAgain) {
  street_->Drive("beside", {.images = 8, .first_m = 60.3, .aside_m = 0.5, .seed = 3});
  AddRequest request = street_->MakeAdd({"beside"});
  request.until = AddUntil::kPlan;
  ASSERT_TRUE(AddExperiences(request).ok());
  ASSERT_TRUE(street_->Remove("lone").ok());
  EXPECT_THAT(Prune(1).experiences, ElementsAre(ExperienceId("lone")));
  request.until = AddUntil::kRelease;
  const auto report = AddExperiences(request);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->added, SizeIs(1));
}

TEST_F(Pruning, WhatIsBuiltButNotReleasedStays) {
  street_->Drive("waiting", {.images = 6, .first_m = 120, .seed = 4});
  AddRequest request = street_->MakeAdd({"waiting"});
  request.until = AddUntil::kPlan;
  const auto planned = AddExperiences(request);
  const auto built = BuildSubmap(street_->MapFolder(), planned->submaps[0].task, {});
  Age(street_->Open().SubmapPath(*built->id));
  EXPECT_EQ(Prune(1).bytes, 0u);
}

TEST_F(Pruning, LeftoversOfKilledProcessesAndOtherOptionsGo) {
  const auto before = street_->Files();
  const fs::path map = street_->MapFolder();
  const MapDirectory directory = street_->Open();
  const SubmapId nobodys = *directory.StoreSubmap(std::vector<std::uint8_t>{1, 2, 3});
  for (const char* name :
       {"submaps/.ab.17.0.tmp", "experiences/lone/features/.x.feat.17.1.tmp",
        "experiences/lone/features/0123.feat", "experiences/lone/tasks/0123.json"}) {
    std::ofstream(map / name) << "left over";
    Age(map / name);
  }
  std::ofstream(map / "submaps/.cd.17.0.tmp") << "being written";
  EXPECT_THAT(Prune(1).submaps, IsEmpty()) << "a builder may be about to name it";
  Age(directory.SubmapPath(nobodys));
  Age(map / "submaps/.cd.17.0.tmp");
  EXPECT_THAT(Prune(1).submaps, ElementsAre(nobodys));
  EXPECT_EQ(street_->Files(), before);
}

TEST_F(Pruning, WhateverWasDeletedBeforeAKillTheNextCallCompletesIt) {
  ASSERT_TRUE(street_->Remove("lone").ok());
  const auto intact = street_->Files();
  fs::remove_all(street_->MapFolder("copy"));
  fs::copy(street_->MapFolder(), street_->MapFolder("copy"), fs::copy_options::recursive);
  const SubmapId submap = street_->Live("original").find("lone")->second;
  ASSERT_THAT(Prune(1).experiences, SizeIs(1));
  const auto pruned = street_->Files();
  for (const int steps : {1, 2}) {  // of the order: experience, submap, release
    fs::remove_all(street_->MapFolder());
    fs::copy(street_->MapFolder("copy"), street_->MapFolder(), fs::copy_options::recursive);
    const MapDirectory map = street_->Open();
    ASSERT_TRUE(map.DeleteExperience(ExperienceId("lone")));
    if (steps > 1) {
      ASSERT_TRUE(map.DeleteSubmap(submap));
    }
    EXPECT_TRUE(street_->Add({"long"}).ok()) << "the map is usable";
    Prune(1);
    EXPECT_EQ(street_->Files(), pruned);
  }
}

TEST_F(Pruning, NothingKeptIsRefused) {
  EXPECT_EQ(PruneMap({.map_folder = street_->MapFolder(), .keep = 0}).error().code,
            ErrorCode::kInvalidArgument);
  EXPECT_EQ(PruneMap({.map_folder = street_->folder()}).error().code, ErrorCode::kNotFound);
  const auto lock = street_->Open().LockForWriting();
  EXPECT_EQ(PruneMap({.map_folder = street_->MapFolder()}).error().code, ErrorCode::kConflict);
}

}  // namespace
}  // namespace waymark::mapping
