// SPDX-License-Identifier: Apache-2.0
// What years of daily adding and removing do to a map.
#include <gmock/gmock.h>

#include <algorithm>

#include "mapping/pipeline/pruning.h"
#include "mapping/store/release_diff.h"
#include "tests/mapping/pipeline/street_map.h"

namespace waymark::mapping {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

std::set<SubmapId> Ids(const std::multimap<std::string, SubmapId>& live) {
  std::set<SubmapId> ids;
  for (const auto& [drive, id] : live) ids.insert(id);
  return ids;
}

/// Where every own image of the live release stands, by experience and name, in the truth's frame.
std::map<std::pair<std::string, std::string>, Eigen::Vector3d> Places(const StreetMap& street,
                                                                      const std::string& map) {
  std::map<std::pair<std::string, std::string>, Eigen::Vector3d> places;
  const MapDirectory directory = street.Open(map);
  const TangentPlane map_plane(directory.description().origin);
  const TangentPlane truth_plane(StreetOrigin());
  const Release release = *directory.LoadCurrentRelease();
  for (const ReleasedSubmap& submap : release.submaps) {
    const auto view = *SubmapView::Open(directory.SubmapPath(submap.id));
    for (const SubmapImage& image : view.images()) {
      if (image.is_borrowed) continue;
      const Point<Map> found(submap.map_from_submap.sim() * image.submap_from_camera.translation());
      places[{image.experience.text(), image.name}] =
          truth_plane.ToMap(map_plane.ToGeo(found)).coordinates();
    }
  }
  return places;
}

TEST(Updates, ACandidateIsStoredAndGoesLiveWhenItIsAddedOnceMore) {
  const StreetMap street("candidate");
  street.Drive("base", {.images = 6});
  street.Drive("north", {.images = 6, .first_m = 60, .seed = 2});
  ASSERT_TRUE(street.Add({"base"}).ok());
  AddRequest request = street.MakeAdd({"north"});
  request.until = AddUntil::kCandidate;
  const auto stored = AddExperiences(request);
  ASSERT_TRUE(stored.ok()) << ToString(stored.error());
  EXPECT_EQ(stored->epoch, 2u);
  EXPECT_EQ(*street.Open().LoadCurrentEpoch(), 1u);
  EXPECT_THAT(street.Open().LoadRelease(2)->submaps, SizeIs(2));
  request.until = AddUntil::kRelease;
  const auto live = AddExperiences(request);
  ASSERT_TRUE(live.ok()) << ToString(live.error());
  EXPECT_EQ(live->epoch, 2u) << "the candidate, not another of the same submaps";
  EXPECT_EQ(*street.Open().LoadCurrentEpoch(), 2u);
}

TEST(Updates, DrivesThatDoNotMeetGiveTheSameBytesInEitherOrder) {
  const StreetMap street("order_apart");
  street.Drive("base", {.images = 6});
  street.Drive("north", {.images = 6, .first_m = 60, .seed = 2});
  street.Drive("south", {.images = 6, .first_m = -60, .seed = 3});
  for (const auto& [map, one, other] :
       {std::tuple{"ns", "north", "south"}, std::tuple{"sn", "south", "north"}}) {
    for (const std::string drive : {"base", one, other}) {
      ASSERT_TRUE(street.Add({drive}, map).ok());
    }
  }
  EXPECT_EQ(street.Live("ns"), street.Live("sn"));
  const ReleaseDiff diff = CompareReleases(*street.Open("ns").LoadCurrentRelease(),
                                           *street.Open("sn").LoadCurrentRelease());
  EXPECT_THAT(diff.moved, SizeIs(3));
  EXPECT_LT(diff.worst.translation_m, 0.001);
}

// The later drive borrows images of the earlier one, so the submaps differ in what they hold
// besides their own images; those stand where they stand.
TEST(Updates, DrivesThatMeetGiveTheSameOwnImagesInTheSamePlacesInEitherOrder) {
  const StreetMap street("order_meeting");
  street.Drive("one", {.images = 10});
  street.Drive("two", {.images = 10, .first_m = 0.3, .aside_m = 0.5, .seed = 2});
  for (const auto& [map, first, second] :
       {std::tuple{"12", "one", "two"}, std::tuple{"21", "two", "one"}}) {
    ASSERT_TRUE(street.Add({first}, map).ok());
    ASSERT_TRUE(street.Add({second}, map).ok());
  }
  EXPECT_EQ(street.Live("12").size(), street.Live("21").size());
  EXPECT_NE(Ids(street.Live("12")), Ids(street.Live("21"))) << "they borrow differently";
  const auto in_12 = Places(street, "12");
  const auto in_21 = Places(street, "21");
  ASSERT_THAT(in_12, SizeIs(20));
  ASSERT_THAT(in_21, SizeIs(20));
  double worst_m = 0;
  for (const auto& [image, place] : in_12) {
    ASSERT_TRUE(in_21.contains(image)) << image.first << " " << image.second;
    worst_m = std::max(worst_m, (place - in_21.at(image)).norm());
  }
  EXPECT_LT(worst_m, 0.1);
  RecordProperty("worst_difference_mm", static_cast<int>(1000 * worst_m));
}

TEST(Updates, AMapThatIsFusedAnewDoesNotRememberWhatItHeld) {
  const StreetMap street("no_trace");
  street.Drive("stays", {.images = 10});
  street.Drive("goes", {.images = 10, .first_m = 0.3, .aside_m = 0.5, .seed = 2});
  ASSERT_TRUE(street.Add({"stays"}).ok());
  ASSERT_TRUE(street.Add({"goes"}).ok());
  RemoveRequest request = street.MakeRemove();
  request.experiences.emplace_back("goes");
  request.places_anew = true;
  ASSERT_TRUE(RemoveFromMap(request).ok());
  const ReleaseDiff diff =
      CompareReleases(*street.Open().LoadRelease(1), *street.Open().LoadRelease(3));
  EXPECT_THAT(diff.added, IsEmpty());
  EXPECT_THAT(diff.removed, IsEmpty());
  EXPECT_LT(diff.worst.translation_m, 0.001);
  EXPECT_LT(diff.worst.rotation_rad, 1e-4);
}

std::uintmax_t Sum(const std::map<std::string, std::uintmax_t>& files) {
  std::uintmax_t total = 0;
  for (const auto& [name, size] : files) total += size;
  return total;
}

TEST(Updates, AHundredLeaveNoFilesMoveNothingAndDoNotGrowTheMap) {
  constexpr int kUpdates = 100;
  const StreetMap street("hundred");
  street.Drive("stays", {.images = 8});
  street.Drive("near", {.images = 8, .first_m = 0.3, .aside_m = 0.5, .seed = 2});
  street.Drive("far", {.images = 8, .first_m = 60, .seed = 3});
  ASSERT_TRUE(street.Add({"stays"}).ok());
  ASSERT_TRUE(street.Add({"near", "far"}).ok());
  ASSERT_TRUE(PruneMap({.map_folder = street.MapFolder(), .keep = 1}).ok());
  const auto live = street.Live();
  const auto files = street.Files();
  const Release first = *street.Open().LoadCurrentRelease();
  std::uintmax_t largest = 0;
  for (int update = 0; update < kUpdates; ++update) {
    const std::string drive = update % 4 < 2 ? "near" : "far";
    const bool removes = update % 2 == 0;
    if (removes) {
      const Release before = *street.Open().LoadCurrentRelease();
      ASSERT_TRUE(street.Remove(drive).ok()) << update;
      const ReleaseDiff diff = CompareReleases(before, *street.Open().LoadCurrentRelease());
      ASSERT_LT(diff.worst.translation_m, 1e-9) << update;
      EXPECT_THAT(street.Live(), SizeIs(live.size() - 1));
    } else {
      ASSERT_TRUE(street.Add({drive}).ok()) << update;
      EXPECT_EQ(street.Live(), live);
      const ReleaseDiff diff = CompareReleases(first, *street.Open().LoadCurrentRelease());
      ASSERT_LT(diff.worst.translation_m, 0.001) << update;
      ASSERT_LT(diff.worst.rotation_rad, 1e-4) << update;
    }
    ASSERT_TRUE(PruneMap({.map_folder = street.MapFolder(), .keep = 2}).ok());
    largest = std::max(largest, Sum(street.Files()));
  }
  const Release last = *street.Open().LoadCurrentRelease();
  EXPECT_EQ(last.epoch, first.epoch + kUpdates);
  ASSERT_TRUE(PruneMap({.map_folder = street.MapFolder(), .keep = 1}).ok());
  std::set<std::string> before, after;
  for (const auto& [name, size] : files) before.insert(name);
  for (const auto& [name, size] : street.Files()) after.insert(name);
  EXPECT_EQ(before.erase("releases/2.json"), 1u);
  EXPECT_EQ(after.erase(fmt::format("releases/{}.json", last.epoch)), 1u);
  EXPECT_EQ(after, before);
  constexpr std::uintmax_t kOneRelease = 10'000;
  EXPECT_LT(largest, Sum(files) + kOneRelease) << "two releases instead of one";
}

}  // namespace
}  // namespace waymark::mapping
