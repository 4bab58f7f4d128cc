// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/batch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "localiser/internal/query_images.h"
#include "mapping/base/file.h"

namespace waymark::localiser::internal {
namespace {

TEST(ParseCamera, ReadsKapturesOrder) {
  const auto camera = ParseCamera("PINHOLE, 640,480,520,521,320,240.5");
  ASSERT_TRUE(camera.ok()) << ToString(camera.error());
  EXPECT_EQ(camera->width_px(), 640);
  EXPECT_EQ(camera->FocalY(), 521);
  EXPECT_EQ(camera->PrincipalPoint(), Eigen::Vector2d(320, 240.5));
}

TEST(ParseCamera, RefusesWhatIsNoCamera) {
  for (const char* text :
       {"", "PINHOLE", "PINHOLE,640,480", "FISH,640,480,1,1,1,1", "PINHOLE,640,480,x,1,1,1",
        "PINHOLE,0,480,1,1,1,1", "PINHOLE,1e300,480,1,1,1,1", "PINHOLE,640,480,1,1,1,1,"}) {
    EXPECT_FALSE(ParseCamera(text).ok()) << text;
  }
}

TEST(GnssAt, InterpolatesBetweenRecordsAndKnowsNothingLongAfter) {
  const auto at = [](double s) {
    return FromNanoseconds<SensorTime>(static_cast<std::int64_t>(s * 1e9));
  };
  mapping::Experience experience{.id = ExperienceId("e")};
  experience.gnss = {{at(10), "gps", {Angle::Degrees(10), Angle::Degrees(179.9), 5}, 1},
                     {at(12), "gps", {Angle::Degrees(11), Angle::Degrees(-179.9), 7}, 2}};
  const auto middle = GnssAt(experience, at(11.5));
  ASSERT_TRUE(middle.has_value());
  EXPECT_NEAR(middle->place.latitude.degrees(), 10.75, 1e-9);
  EXPECT_NEAR(middle->place.longitude.degrees(), -179.95, 1e-9);
  EXPECT_NEAR(middle->place.ellipsoid_height_m, 6.5, 1e-9);
  EXPECT_EQ(middle->sigma_m, 2);
  EXPECT_NEAR(GnssAt(experience, at(14))->place.latitude.degrees(), 11, 1e-9);
  EXPECT_NEAR(GnssAt(experience, at(8))->place.latitude.degrees(), 10, 1e-9);
  EXPECT_FALSE(GnssAt(experience, at(30)).has_value());
}

class QueryFolder : public testing::Test {
 protected:
  QueryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "waymark-query-XXXXXX");
    folder_ = mkdtemp(pattern.data());
    std::filesystem::create_directories(folder_ / "b");
    for (const char* name : {"b/2.JPG", "a.png", "notes.txt"}) {
      CHECK(StoreFileAtomically(folder_ / name, std::string_view("x")).ok());
    }
  }
  ~QueryFolder() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

TEST_F(QueryFolder, PlainFoldersGiveTheirPhotosByName) {
  const auto images = FindQueryImages(folder_, std::nullopt);
  ASSERT_TRUE(images.ok()) << ToString(images.error());
  ASSERT_EQ(images->size(), 2u);
  EXPECT_EQ((*images)[0].name, "a.png");
  EXPECT_EQ((*images)[1].name, "b/2.JPG");
}

TEST_F(QueryFolder, ListsSelectAndUnknownNamesAreErrors) {
  const auto images = FindQueryImages(folder_, std::nullopt);
  const auto list = folder_ / "list.txt";
  CHECK(StoreFileAtomically(list, std::string_view("b/2.JPG\r\n\n")).ok());
  const auto selected = SelectListed(*images, list);
  ASSERT_TRUE(selected.ok()) << ToString(selected.error());
  ASSERT_EQ(selected->size(), 1u);
  CHECK(StoreFileAtomically(list, std::string_view("c.png\n")).ok());
  EXPECT_EQ(SelectListed(*images, list).error().code, ErrorCode::kNotFound);
}

TEST_F(QueryFolder, FoldersWithoutImagesAreErrorsThatSaySo) {
  std::filesystem::remove(folder_ / "a.png");
  std::filesystem::remove(folder_ / "b/2.JPG");
  const auto images = FindQueryImages(folder_, std::nullopt);
  ASSERT_FALSE(images.ok());
  EXPECT_THAT(images.error().message, testing::HasSubstr("found none"));
}

TEST(PoseTable, HasOneLinePerImageAndQuotesOddNames) {
  std::vector<LocalisedImage> images(2);
  images[0].name = "a, \"b\".jpg";
  images[0].answer.status = LocalisationStatus::kTooFewMatches;
  images[1].name = "c.jpg";
  images[1].answer.status = LocalisationStatus::kLocalised;
  images[1].answer.epoch = 3;
  images[1].answer.times.total_ms = 12.34;
  images[1].answer.pose =
      LocalisedPose{.map_from_camera = Transform<Map, Camera>(Eigen::Quaterniond::Identity(),
                                                              Eigen::Vector3d(1, 2, 3)),
                    .covariance = Eigen::Matrix<double, 6, 6>::Identity(),
                    .submap = SubmapId("ab12"),
                    .submap_from_camera = {},
                    .inliers = 40,
                    .rms_px = 1,
                    .experience = ExperienceId("night")};
  EXPECT_EQ(EncodePoseTable(images),
            "image,status,tx,ty,tz,qx,qy,qz,qw,inliers,submap,epoch,ms,experience\n"
            "\"a, \"\"b\"\".jpg\",too few matches,,,,,,,,0,,0,0.0,\n"
            "c.jpg,localised,1.000000,2.000000,3.000000,0.000000000,0.000000000,0.000000000,"
            "1.000000000,40,ab12,3,12.3,night\n");
  EXPECT_THAT(Summarise(images), testing::HasSubstr("localised 1 of 2 images (50 %)"));
  EXPECT_THAT(Summarise(images), testing::HasSubstr("too few matches: 1"));
}

TEST(MemoryReport, SaysWhatABudgetCost) {
  EXPECT_EQ(internal::Describe({.resident_bytes = 2'500'000, .resident_submaps = 2}),
            "2 submaps in memory, 2.5 MB");
  EXPECT_EQ(internal::Describe({.budget_bytes = 4'000'000,
                                .resident_bytes = 2'500'000,
                                .peak_bytes = 3'500'000,
                                .resident_submaps = 2,
                                .openings = 3,
                                .evictions = 1,
                                .opening_ms = 600}),
            "2 submaps in memory, 2.5 MB (most 3.5 of 4.0); 3 opened in 200 ms each, 1 dropped");
}

}  // namespace
}  // namespace waymark::localiser::internal
