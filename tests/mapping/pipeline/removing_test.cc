// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/removing.h"

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <csignal>
#include <memory>

#include "mapping/store/release_diff.h"
#include "tests/mapping/pipeline/street_map.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// Two drives that overlap and one 60 m north of them, in a map that every test copies.
class Removing : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    street_ = std::make_unique<StreetMap>("removing");
    street_->Drive("first", {.images = 8});
    street_->Drive("second", {.images = 8, .first_m = 0.3, .aside_m = 0.5, .seed = 2});
    street_->Drive("north", {.images = 8, .first_m = 60, .seed = 3});
    ASSERT_TRUE(street_->Add({"first", "second", "north"}, "original").ok());
    ASSERT_THAT(street_->Live("original"), SizeIs(3));
  }
  static void TearDownTestSuite() { street_.reset(); }

  Removing() {
    fs::remove_all(street_->MapFolder());
    fs::copy(street_->MapFolder("original"), street_->MapFolder(), fs::copy_options::recursive);
  }

  static SubmapId Of(const std::string& drive) { return street_->Live().find(drive)->second; }

  static std::set<std::string> LiveDrives() {
    std::set<std::string> drives;
    for (const auto& [drive, submap] : street_->Live()) drives.insert(drive);
    return drives;
  }

  /// A square around a place on the street.
  static Area Square(double along_m, double half_m) {
    const TangentPlane plane(StreetOrigin());
    Area area;
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      area.push_back(plane.ToGeo(Point<Map>(x * half_m, along_m + y * half_m, 0)));
    }
    return area;
  }

  static ErrorCode RefusalOf(const RemoveRequest& request) {
    const auto before = street_->Files();
    const auto report = RemoveFromMap(request);
    EXPECT_FALSE(report.ok());
    EXPECT_EQ(street_->Files(), before) << "a refused request changes nothing";
    return report.ok() ? ErrorCode::kTimeout : report.error().code;
  }

  static inline std::unique_ptr<StreetMap> street_;
};

TEST_F(Removing, ASubmapGoesAndTheRestStaysWhereItWas) {
  const Release before = *street_->Open().LoadCurrentRelease();
  RemoveRequest request = street_->MakeRemove();
  request.submaps.push_back(Of("north"));
  const auto report = RemoveFromMap(request);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->removed, ElementsAre(request.submaps[0]));
  EXPECT_EQ(report->epoch, 2u);
  EXPECT_THAT(LiveDrives(), ElementsAre("first", "second"));
  const Release after = *street_->Open().LoadCurrentRelease();
  EXPECT_EQ(after.parent_epoch, 1u);
  EXPECT_EQ(after.created_utc, "2026-01-03T03:04:05Z");
  EXPECT_FALSE(after.fusion_s);
  for (const ReleasedSubmap& submap : after.submaps) {
    ASSERT_TRUE(submap.displacement);
    EXPECT_EQ(submap.displacement->translation_m, 0);
  }
  EXPECT_LT(CompareReleases(before, after).worst.translation_m, 1e-9);
  EXPECT_TRUE(fs::exists(street_->Open().SubmapPath(request.submaps[0]))) << "for rollback";
  ASSERT_TRUE(street_->Open().Deploy(1));
  EXPECT_THAT(LiveDrives(), ElementsAre("first", "north", "second"));
}

TEST_F(Removing, AnExperienceGoesWithItsSubmapsButStaysOnDiskWhileAReleaseNeedsIt) {
  const auto report = street_->Remove("second");
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(LiveDrives(), ElementsAre("first", "north"));
  EXPECT_THAT(report->still_needed, ElementsAre(ExperienceId("second")));
  EXPECT_THAT(report->deleted, IsEmpty());
  EXPECT_TRUE(fs::exists(street_->Open().ExperienceFolder(ExperienceId("second"))));
}

TEST_F(Removing, AnAreaTakesTheSubmapsWhoseCentreItHolds) {
  RemoveRequest request = street_->MakeRemove();
  request.areas.push_back(Square(2, 20));
  const auto report = RemoveFromMap(request);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->removed, SizeIs(2));
  EXPECT_THAT(LiveDrives(), ElementsAre("north"));
}

TEST_F(Removing, ACandidateIsStoredButNotLiveUntilItIsDeployed) {
  RemoveRequest request = street_->MakeRemove();
  request.experiences.emplace_back("north");
  request.is_candidate = true;
  ASSERT_EQ(RemoveFromMap(request)->epoch, 2u);
  EXPECT_THAT(LiveDrives(), ElementsAre("first", "north", "second"));
  EXPECT_EQ(RemoveFromMap(request)->epoch, 2u) << "it is stored already";
  request.is_candidate = false;
  EXPECT_EQ(RemoveFromMap(request)->epoch, 2u) << "the candidate goes live";
  EXPECT_THAT(LiveDrives(), ElementsAre("first", "second"));
  EXPECT_THAT(street_->Open().ListReleaseEpochs().value(), ElementsAre(1, 2));
}

TEST_F(Removing, RemovingAgainChangesNothing) {
  RemoveRequest request = street_->MakeRemove();
  request.submaps.push_back(Of("first"));
  request.experiences.emplace_back("north");
  request.areas.push_back(Square(60, 20));
  ASSERT_TRUE(RemoveFromMap(request).ok());
  const auto before = street_->Files();
  const auto again = RemoveFromMap(request);
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_FALSE(again->epoch);
  EXPECT_THAT(again->removed, IsEmpty());
  EXPECT_EQ(street_->Files(), before);
}

TEST_F(Removing, AddingAgainBringsItBackAsItWas) {
  const auto original = street_->Live();
  ASSERT_TRUE(street_->Remove("second").ok());
  const auto report = street_->Add({"first", "second"});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->added, ElementsAre(ExperienceId("second")));
  EXPECT_THAT(report->already_in_map, ElementsAre(ExperienceId("first")));
  ASSERT_THAT(report->submaps, SizeIs(1));
  EXPECT_TRUE(report->submaps[0].was_built_before);
  EXPECT_EQ(street_->Live(), original);
}

TEST_F(Removing, ANewDriveDoesNotBorrowFromWhatWasRemoved) {
  ASSERT_TRUE(street_->Remove("first").ok());
  street_->Drive("third", {.images = 8, .first_m = 0.5, .aside_m = 0.2, .seed = 4});
  ASSERT_TRUE(street_->Add({"third"}).ok());
  const auto view = *SubmapView::Open(street_->Open().SubmapPath(Of("third")));
  std::set<std::string> lenders;
  for (const SubmapImage& image : view.images()) {
    if (image.is_borrowed) lenders.insert(image.experience.text());
  }
  EXPECT_THAT(lenders, ElementsAre("second"));
}

TEST_F(Removing, OtherOptionsReplaceWhatWasBuiltFromAPartlyRemovedDrive) {
  AddRequest request = street_->MakeAdd({"long"});
  request.options.split =
      SplitOptions{.radius_m = 4, .min_radius_m = 3, .overlap_m = 3, .min_images = 4};
  street_->Drive("long", {.images = 14, .first_m = 120, .seed = 5});
  ASSERT_TRUE(AddExperiences(request).ok());
  ASSERT_GE(street_->Live().count("long"), 2u);
  RemoveRequest remove = street_->MakeRemove();
  remove.submaps.push_back(Of("long"));
  ASSERT_TRUE(RemoveFromMap(remove).ok());
  const auto report = street_->Add({"long"});  // one submap holds the whole drive now
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(street_->Live().count("long"), 1u) << "no image stands in the map twice";
}

TEST_F(Removing, WhatWasNeverReleasedIsDeletedAtOnce) {
  street_->Drive("planned", {.images = 6, .first_m = 200});
  AddRequest request = street_->MakeAdd({"planned"});
  request.until = AddUntil::kPlan;
  const auto planned = AddExperiences(request);
  ASSERT_TRUE(BuildSubmap(street_->MapFolder(), planned->submaps[0].task, {})->id);
  const auto report = street_->Remove("planned");
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->deleted, ElementsAre(ExperienceId("planned")));
  EXPECT_FALSE(report->epoch);
  EXPECT_THAT(street_->Open().ListSubmaps().value(), SizeIs(3));
  EXPECT_EQ(street_->Remove("planned").error().code, ErrorCode::kNotFound);
}

TEST_F(Removing, WrongRequestsAreRefusedAndChangeNothing) {
  const RemoveRequest nothing = street_->MakeRemove();
  EXPECT_EQ(RefusalOf(nothing), ErrorCode::kInvalidArgument);
  RemoveRequest request = nothing;
  request.submaps.emplace_back("../../../etc/passwd");
  EXPECT_EQ(RefusalOf(request), ErrorCode::kInvalidArgument);
  request.submaps = {SubmapId(std::string(32, 'a'))};
  EXPECT_EQ(RefusalOf(request), ErrorCode::kNotFound);
  request = nothing;
  request.experiences.emplace_back("nosuch");
  EXPECT_EQ(RefusalOf(request), ErrorCode::kNotFound);
  request.experiences = {ExperienceId("..")};
  EXPECT_EQ(RefusalOf(request), ErrorCode::kInvalidArgument);
  request = nothing;
  request.areas = {{StreetOrigin(), StreetOrigin()}};
  EXPECT_EQ(RefusalOf(request), ErrorCode::kInvalidArgument) << "two corners";
  request.areas = {{StreetOrigin(), StreetOrigin(), StreetOrigin()}};
  EXPECT_EQ(RefusalOf(request), ErrorCode::kInvalidArgument) << "no inside";
  request.areas = {{StreetOrigin(), {Angle::Degrees(95), {}, 0}, {Angle::Degrees(1), {}, 0}}};
  EXPECT_EQ(RefusalOf(request), ErrorCode::kInvalidArgument) << "off the earth";
  request.areas = {Square(30, 500)};
  EXPECT_EQ(RefusalOf(request), ErrorCode::kInvalidArgument) << "a map never goes blank";
  request.map_folder = street_->folder();
  EXPECT_EQ(RefusalOf(request), ErrorCode::kNotFound) << "no map";
}

TEST_F(Removing, AnotherWriterIsAConflict) {
  const auto lock = street_->Open().LockForWriting();
  EXPECT_EQ(street_->Remove("north").error().code, ErrorCode::kConflict);
}

TEST_F(Removing, AKilledRemovalIsSimplyRunAgain) {
  for (const std::size_t done : {0u, 1u, 2u}) {
    const pid_t child = fork();
    if (child == 0) {
      RemoveRequest request = street_->MakeRemove();
      request.experiences.emplace_back("north");
      request.places_anew = true;
      PipelineObserver observer;
      observer.on_progress = [&](const PipelineProgress& progress) {
        if (progress.done >= done) raise(SIGKILL);
      };
      [[maybe_unused]] const auto ignored = RemoveFromMap(request, observer);
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    EXPECT_THAT(LiveDrives(), ElementsAre("first", "north", "second"));
  }
  ASSERT_EQ(street_->Remove("north")->epoch, 2u);
  fs::remove(street_->MapFolder() / "current");  // as if killed between storing and deploying
  ASSERT_TRUE(street_->Open().Deploy(1));
  EXPECT_EQ(street_->Remove("north")->epoch, 2u);
  EXPECT_THAT(LiveDrives(), ElementsAre("first", "second"));
  EXPECT_THAT(street_->Open().ListReleaseEpochs().value(), ElementsAre(1, 2));
}

}  // namespace
}  // namespace waymark::mapping
