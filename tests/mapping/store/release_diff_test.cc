// SPDX-License-Identifier: Apache-2.0
#include "mapping/store/release_diff.h"

#include <gmock/gmock.h>

#include "tests/mapping/store/example_release.h"

namespace waymark::mapping {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// The release as it would be had everything turned by `radians` about a submap's own centre, grown
/// by `scale` about it, and gone `metres` east.
ReleasedSubmap Displaced(ReleasedSubmap submap, double metres, double radians, double scale) {
  const Eigen::Vector3d centre = submap.centre.coordinates();
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(radians, Eigen::Vector3d::UnitZ()));
  const Sim3 about_centre(scale, turn,
                          centre + metres * Eigen::Vector3d::UnitX() - scale * (turn * centre));
  submap.map_from_submap = Similarity<Map, Submap>(about_centre * submap.map_from_submap.sim());
  submap.centre = Point<Map>(about_centre * centre);
  return submap;
}

TEST(ReleaseDiff, EqualReleasesDoNotDiffer) {
  const Release release = ExampleRelease();
  const ReleaseDiff diff = CompareReleases(release, release);
  EXPECT_THAT(diff.moved, SizeIs(3));
  EXPECT_THAT(diff.added, IsEmpty());
  EXPECT_THAT(diff.removed, IsEmpty());
  EXPECT_LT(diff.worst.translation_m, 1e-9);
  EXPECT_LT(diff.worst.rotation_rad, 1e-7);
  EXPECT_NEAR(diff.worst.scale_ratio, 1, 1e-12);
}

TEST(ReleaseDiff, DisplacementsAreMeasuredAtTheCentreFarthestFirst) {
  const Release from = ExampleRelease(1);
  Release to = ExampleRelease(2);
  to.submaps[0] = Displaced(from.submaps[0], 0.02, 0.001, 1.0001);
  to.submaps[1] = Displaced(from.submaps[1], 0.5, 0.1, 0.99);
  to.submaps[2] = Displaced(from.submaps[2], 0.1, 0.01, 1.001);
  const ReleaseDiff diff = CompareReleases(from, to);
  EXPECT_EQ(diff.from_epoch, 1u);
  EXPECT_EQ(diff.to_epoch, 2u);
  ASSERT_THAT(diff.moved, SizeIs(3));
  EXPECT_EQ(diff.moved[0].id, from.submaps[1].id);
  EXPECT_EQ(diff.moved[1].id, from.submaps[2].id);
  EXPECT_EQ(diff.moved[2].id, from.submaps[0].id);
  EXPECT_NEAR(diff.moved[1].displacement.translation_m, 0.1, 1e-9);
  EXPECT_NEAR(diff.moved[1].displacement.rotation_rad, 0.01, 1e-9);
  EXPECT_NEAR(diff.moved[1].displacement.scale_ratio, 1.001, 1e-9);
  EXPECT_NEAR(diff.worst.translation_m, 0.5, 1e-9);
  EXPECT_NEAR(diff.worst.scale_ratio, 0.99, 1e-9) << "1 % smaller is more than 0.1 % larger";
  EXPECT_NEAR(diff.median.translation_m, 0.1, 1e-9);
  EXPECT_NEAR(diff.median.rotation_rad, 0.01, 1e-9);
}

TEST(ReleaseDiff, WhatOnlyOneReleaseHoldsIsAddedOrRemoved) {
  const Release all = ExampleRelease();
  Release without_first = all;
  without_first.submaps.erase(without_first.submaps.begin());
  Release without_last = all;
  without_last.submaps.pop_back();
  const ReleaseDiff diff = CompareReleases(without_first, without_last);
  EXPECT_THAT(diff.added, ElementsAre(all.submaps[0].id));
  EXPECT_THAT(diff.removed, ElementsAre(all.submaps[2].id));
  EXPECT_THAT(diff.moved, SizeIs(1));
  const ReleaseDiff all_new = CompareReleases(Release{}, all);
  EXPECT_THAT(all_new.added, SizeIs(3));
  EXPECT_EQ(all_new.worst.translation_m, 0);
  EXPECT_EQ(all_new.worst.scale_ratio, 1);
}

TEST(ReleaseDiff, JsonNamesEverything) {
  Release to = ExampleRelease(4);
  to.submaps.pop_back();
  const std::string json = EncodeReleaseDiff(CompareReleases(ExampleRelease(3), to));
  EXPECT_THAT(json, HasSubstr("\"from_epoch\": 3"));
  EXPECT_THAT(json, HasSubstr("\"to_epoch\": 4"));
  EXPECT_THAT(json, HasSubstr(ExampleRelease().submaps[2].id.text()));
  EXPECT_THAT(json, HasSubstr("\"translation_m\""));
}

}  // namespace
}  // namespace waymark::mapping
