// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/kapture.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>

#include "tests/mapping/experience/kapture_folder.h"
#include "tests/support/random_geometry.h"

namespace waymark::mapping {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

class Kapture : public KaptureFolder {};

TEST_F(Kapture, AValidFolderIsReadWhole) {
  const auto loaded = LoadKapture(folder_ / "");
  ASSERT_TRUE(loaded) << ToString(loaded.error());
  const Experience& experience = *loaded;
  EXPECT_EQ(experience.id.text(), "walk");
  ASSERT_EQ(experience.cameras.size(), 2u);
  EXPECT_EQ(experience.cameras.at("cam0").model.parameters()[7], -0.002);
  EXPECT_TRUE(experience.cameras.at("cam0").has_known_focal);
  ASSERT_EQ(experience.rigs.size(), 1u);
  EXPECT_THAT(experience.rigs[0].sensor_from_rig,
              support::Near(Rigid3(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), {0.1, 0.2, 1.5})));
  EXPECT_EQ(experience.accelerometer.at(0).value, Eigen::Vector3d(0.1, 9.8, -0.2));
  EXPECT_EQ(experience.gyroscope.at(0).sensor, "gyro0");
  EXPECT_EQ(experience.trajectory.at(0).device_from_world.translation(), Eigen::Vector3d(1, 2, 3));
}

TEST_F(Kapture, RecordsAreSortedByTime) {
  const auto experience = LoadKapture(folder_).value();
  ASSERT_EQ(experience.images.size(), 2u);
  EXPECT_EQ(experience.images[0].name, "front/1.jpg");
  EXPECT_EQ(ToNanoseconds(experience.images[1].time), 200);
  EXPECT_EQ(ToNanoseconds(experience.gnss[0].time), 90);
}

TEST_F(Kapture, GnssIsLongitudeFirstAndDopIsMetres) {
  const auto experience = LoadKapture(folder_).value();
  EXPECT_DOUBLE_EQ(experience.gnss[1].place.longitude.degrees(), -122.4194);
  EXPECT_DOUBLE_EQ(experience.gnss[1].place.latitude.degrees(), 37.7749);
  EXPECT_EQ(experience.gnss[1].place.ellipsoid_height_m, 16.5);
  EXPECT_EQ(experience.gnss[1].sigma_m, 2.5);
  EXPECT_EQ(experience.gnss[0].sigma_m, 5) << "a dop of 0 is unknown";
}

TEST_F(Kapture, AnUnknownCameraGetsAGuessedFocalLength) {
  const auto experience = LoadKapture(folder_).value();
  const CameraSensor& camera = experience.cameras.at("cam1");
  EXPECT_FALSE(camera.has_known_focal);
  EXPECT_EQ(camera.model.FocalX(), 480);
  EXPECT_EQ(camera.model.PrincipalPoint(), Eigen::Vector2d(150, 200));
}

TEST_F(Kapture, CarriageReturnsAndMissingOptionalTablesAreAccepted) {
  Write("records_camera.txt", "# kapture format: 1.1\r\n\r\n100, cam0, front/1.jpg\r\n");
  for (const char* name : {"rigs.txt", "records_gnss.txt", "records_accelerometer.txt",
                           "records_gyroscope.txt", "trajectories.txt"}) {
    std::filesystem::remove(folder_ / "sensors" / name);
  }
  const auto experience = LoadKapture(folder_);
  ASSERT_TRUE(experience) << ToString(experience.error());
  EXPECT_EQ(experience->images.at(0).name, "front/1.jpg");
  EXPECT_TRUE(experience->gnss.empty());
}

TEST_F(Kapture, StoringAndLoadingGivesTheSameExperience) {
  const auto first = LoadKapture(folder_).value();
  const auto copy = root_ / "copy" / "walk";
  ASSERT_TRUE(StoreKapture(first, copy));
  std::filesystem::copy(folder_ / "sensors" / "records_data", copy / "sensors" / "records_data",
                        std::filesystem::copy_options::recursive);
  const auto second = LoadKapture(copy);
  ASSERT_TRUE(second) << ToString(second.error());
  EXPECT_EQ(second->id, first.id);
  EXPECT_EQ(second->cameras.at("cam0").model, first.cameras.at("cam0").model);
  EXPECT_EQ(second->cameras.at("cam1").model, first.cameras.at("cam1").model);
  EXPECT_FALSE(second->cameras.at("cam1").has_known_focal);
  EXPECT_THAT(second->rigs.at(0).sensor_from_rig, support::Near(first.rigs.at(0).sensor_from_rig));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(second->images.at(i).name, first.images[i].name);
    EXPECT_EQ(second->images[i].time, first.images[i].time);
    EXPECT_EQ(second->gnss.at(i).sigma_m, first.gnss[i].sigma_m);
    EXPECT_LT(GeodesicDistance(second->gnss[i].place, first.gnss[i].place), 1e-8);
  }
  EXPECT_EQ(second->accelerometer.at(0).value, first.accelerometer[0].value);
  EXPECT_THAT(second->trajectory.at(0).device_from_world,
              support::Near(first.trajectory[0].device_from_world));
}

TEST_F(Kapture, ARigKeepsOnlyMembersThatRecordedSomething) {
  Write("rigs.txt",
        kHeader + "rig0, cam0, 1, 0, 0, 0, 0, 0, 0\nrig0, gyro0, 1, 0, 0, 0, 0, 0, 0\n");
  auto experience = LoadKapture(folder_).value();
  ASSERT_EQ(experience.rigs.size(), 2u);
  experience.gyroscope.clear();
  ASSERT_TRUE(StoreKapture(experience, folder_));
  const auto again = LoadKapture(folder_).value();
  ASSERT_EQ(again.rigs.size(), 1u);
  EXPECT_EQ(again.rigs[0].sensor, "cam0");
}

TEST_F(Kapture, StoringOverAnOldExperienceLeavesNothingOfIt) {
  auto experience = LoadKapture(folder_).value();
  experience.gnss.clear();
  experience.rigs.clear();
  experience.trajectory.clear();
  ASSERT_TRUE(StoreKapture(experience, folder_));
  const auto again = LoadKapture(folder_).value();
  EXPECT_TRUE(again.gnss.empty());
  EXPECT_TRUE(again.rigs.empty());
}

TEST_F(Kapture, WhatKaptureCannotSpellIsNotStored) {
  const auto good = LoadKapture(folder_).value();
  auto with_comma = good;
  with_comma.images[0].name = "a,b.jpg";
  auto escaping = good;
  escaping.images[0].name = "../../etc/passwd";
  auto nan = good;
  nan.gyroscope[0].value.x() = std::nan("");
  auto stranger = good;
  stranger.images[0].camera = "cam9";
  for (const Experience& bad : {with_comma, escaping, nan, stranger}) {
    const auto stored = StoreKapture(bad, root_ / "refused");
    ASSERT_FALSE(stored);
    EXPECT_EQ(stored.error().code, ErrorCode::kInvalidArgument);
  }
  EXPECT_FALSE(std::filesystem::exists(root_ / "refused"));
}

TEST_F(Kapture, AFolderThatIsNoKaptureIsExplained) {
  const auto missing = LoadKapture(root_ / "nowhere");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, AllOf(HasSubstr("nowhere"), HasSubstr("sensors.txt")));
}

TEST_F(Kapture, AMissingImageIsNamed) {
  std::filesystem::remove(folder_ / "sensors/records_data/front/2.jpg");
  const auto result = LoadKapture(folder_);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(result.error().message, HasSubstr("front/2.jpg"));
}

TEST(KaptureOnRealData, EveryRecordingLoads) {
  const char* data = std::getenv("WAYMARK_DATA");
  if (data == nullptr) GTEST_SKIP() << "WAYMARK_DATA names no folder with real recordings";
  const std::map<std::string, std::size_t> image_counts{
      {"fountain", 11}, {"kitti_clip_1", 51}, {"kitti_clip_2", 51}, {"pavilion_midday", 50}};
  for (const auto& [name, count] : image_counts) {
    const auto experience = LoadKapture(std::filesystem::path(data) / name);
    ASSERT_TRUE(experience) << ToString(experience.error());
    EXPECT_EQ(experience->images.size(), count) << name;
    EXPECT_FALSE(experience->gnss.empty()) << name;
  }
}

}  // namespace
}  // namespace waymark::mapping
