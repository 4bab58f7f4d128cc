// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mapping/base/file.h"
#include "mapping/experience/kapture.h"
#include "mapping/io/submap_file.h"
#include "mapping/store/map_directory.h"
#include "tests/evaluation/running.h"

namespace waymark::evaluation {
namespace {

TEST(StoreKaptureSubset, LeavesAKaptureFolderWithTheChosenImages) {
  const ScratchFolder scratch(false);
  const auto from = scratch.path() / "drive";
  const auto store = [&](const char* name, std::string_view text) {
    ASSERT_TRUE(StoreFileAtomically(from / "sensors" / name, text).ok());
  };
  ASSERT_TRUE(CreateFolders(from / "sensors/records_data").ok());
  store("sensors.txt",
        "# kapture format: 1.1\ncam0, , camera, PINHOLE, 640, 480, 500, 500, 320, 240\n");
  store("records_camera.txt",
        "# kapture format: 1.1\n1, cam0, a.png\n2, cam0, b.png\n3, cam0, c.png\n");
  for (const char* name : {"a.png", "b.png", "c.png"})
    store((std::string("records_data/") + name).c_str(), "x");

  const auto to = scratch.path() / "even";
  const auto kept = StoreKaptureSubset(
      from, to, [](std::size_t index, const std::string&) { return index % 2 == 0; });
  ASSERT_TRUE(kept.ok()) << ToString(kept.error());
  EXPECT_THAT(*kept, testing::ElementsAre("a.png", "c.png"));
  const auto experience = mapping::LoadKapture(to);
  ASSERT_TRUE(experience.ok()) << ToString(experience.error());
  ASSERT_EQ(experience->images.size(), 2u);
  EXPECT_TRUE(std::filesystem::exists(experience->ImagePath(experience->images[1])));
}

mapping::SubmapImage ImageAt(const std::string& name, double x, bool is_borrowed) {
  return {
      .experience = ExperienceId("drive"),
      .name = name,
      .camera = 0,
      .submap_from_camera = Transform<Submap, Camera>(Eigen::Quaterniond::Identity(), {x, 0, 0}),
      .gnss = std::nullopt,
      .gnss_sigma_m = 1,
      .is_borrowed = is_borrowed};
}

TEST(LoadMapPoses, TakesEachImageFromTheSubmapItBelongsTo) {
  const ScratchFolder scratch(false);
  const GeoPoint origin{Angle::Degrees(37), Angle::Degrees(-122), 0};
  const auto map = mapping::MapDirectory::Create(
      scratch.path() / "map", {"8f0f5f1e-6d0a-4a53-9d54-0f4f2a1c7b11", origin, true, "{}"});
  ASSERT_TRUE(map.ok()) << ToString(map.error());
  mapping::Release release;
  release.created_utc = "2026-01-01T00:00:00Z";
  for (const bool first : {true, false}) {
    mapping::SubmapModel model;
    model.origin = origin;
    model.cameras.push_back(
        *CameraModel::Create(CameraKind::kSimplePinhole, 10, 10, std::vector<double>{10, 5, 5}));
    model.images = {ImageAt("a.png", first ? 1 : 7, !first), ImageAt("b.png", 2, first)};
    const auto id = map->StoreSubmap(*mapping::EncodeSubmap(model));
    ASSERT_TRUE(id.ok()) << ToString(id.error());
    release.submaps.push_back({*id,
                               Similarity<Map, Submap>(Sim3(2, Eigen::Quaterniond::Identity(),
                                                            Eigen::Vector3d(0, first, 0))),
                               Point<Map>(0, 0, 0), 10, 0, 0, std::nullopt});
  }
  std::sort(release.submaps.begin(), release.submaps.end(),
            [](const auto& a, const auto& b) { return a.id < b.id; });
  ASSERT_TRUE(map->StoreRelease(release).ok());
  ASSERT_TRUE(map->Deploy(1).ok());
  const auto poses = LoadMapPoses(scratch.path() / "map");
  ASSERT_TRUE(poses.ok()) << ToString(poses.error());
  EXPECT_EQ(poses->submaps, 2u);
  EXPECT_EQ(poses->largest_submap, 1u);
  EXPECT_EQ(poses->map_from_camera.at("a.png").translation(), Eigen::Vector3d(2, 1, 0));
  EXPECT_EQ(poses->map_from_camera.at("b.png").translation(), Eigen::Vector3d(4, 0, 0));
}

}  // namespace
}  // namespace waymark::evaluation
