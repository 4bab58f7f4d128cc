// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/import_photos.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <map>
#include <random>

#include "mapping/experience/internal/jpeg_structure.h"
#include "mapping/experience/internal/photo_exif.h"
#include "mapping/experience/kapture.h"
#include "tests/mapping/experience/photo_folder.h"

namespace waymark::mapping {
namespace {

TEST_F(ImportedPhotos, KeepTimePlaceAndFocalLength) {
  WritePhoto("day/a.JPG", kFullTags);
  const auto import = Import();
  ASSERT_TRUE(import) << ToString(import.error());
  const Experience& experience = import->experience;
  EXPECT_EQ(experience.id.text(), "walk");
  ASSERT_EQ(experience.images.size(), 1u);
  EXPECT_EQ(experience.images[0].name, "day/a.JPG");
  EXPECT_EQ(ToNanoseconds(experience.images[0].time), 1714566615'250'000'000);
  EXPECT_EQ(import->times, PhotoTimes::kCaptured);
  ASSERT_EQ(experience.gnss.size(), 1u);
  EXPECT_EQ(experience.gnss[0].time, experience.images[0].time);
  EXPECT_NEAR(experience.gnss[0].place.latitude.degrees(), -(33 + 51 / 60.0 + 30.3 / 3600), 1e-12);
  EXPECT_NEAR(experience.gnss[0].place.longitude.degrees(), -70.5, 1e-12);
  EXPECT_EQ(experience.gnss[0].place.ellipsoid_height_m, -12.5);
  EXPECT_EQ(experience.gnss[0].sigma_m, 3);
  const CameraSensor& camera = experience.cameras.at("cam0");
  EXPECT_TRUE(camera.has_known_focal);
  EXPECT_NEAR(camera.model.FocalX(), 28 / 43.2666 * 500, 1e-9);
  EXPECT_TRUE(LoadKapture(root_ / "walk")) << "the folder stands on its own";
}

TEST_F(ImportedPhotos, ThatCannotServeAreLeftOutWithAReason) {
  WritePhoto("good.jpg", kFullTags);
  WritePhoto("none.jpg", {});
  WritePhoto("huge.jpg", kFullTags, 20000, 20000);
  WritePhoto("a,b.jpg", kFullTags);
  const auto good = LoadFile(root_ / "photos" / "good.jpg").value();
  Write("cut.jpg", std::span(good).first(good.size() - 1));
  Write("text.jpeg", std::vector<std::uint8_t>{'h', 'i'});
  Write("other.png", std::vector<std::uint8_t>{1});
  Write("notes.txt", std::vector<std::uint8_t>{1});
  const auto import = Import();
  ASSERT_TRUE(import) << ToString(import.error());
  EXPECT_EQ(import->experience.images.size(), 1u);
  std::map<std::string, std::string> reasons;
  for (const auto& [name, reason] : import->left_out) reasons[name] = reason;
  EXPECT_EQ(reasons,
            (std::map<std::string, std::string>{{"none.jpg", "has no EXIF"},
                                                {"huge.jpg", "has more than 100 megapixels"},
                                                {"a,b.jpg", "has a name that kapture cannot spell"},
                                                {"cut.jpg", "is cut short"},
                                                {"text.jpeg", "is no JPEG"},
                                                {"other.png", "is no JPEG"}}));
}

TEST_F(ImportedPhotos, WithoutGpsStay) {
  WritePhoto("a.jpg", kFullTags);
  WritePhoto("b.jpg", Without("Exif.GPSInfo.GPSLatitude"));
  WritePhoto("c.jpg", With("Exif.GPSInfo.GPSStatus", "V"));
  WritePhoto("d.jpg", With("Exif.GPSInfo.GPSLatitude", "95/1 0/1 0/1"));
  WritePhoto("e.jpg", With("Exif.GPSInfo.GPSLatitude", "5/0 0/0 0/0"));
  const auto import = Import();
  ASSERT_TRUE(import) << ToString(import.error());
  EXPECT_EQ(import->experience.images.size(), 5u);
  EXPECT_EQ(import->experience.gnss.size(), 1u);
  EXPECT_EQ(import->photos_without_gps, 4u);
}

TEST_F(ImportedPhotos, OfOneSecondGetInstantsOfTheirOwn) {
  WritePhoto("a.jpg", kFullTags);
  WritePhoto("b.jpg", kFullTags);
  const auto experience = Import().value().experience;
  EXPECT_EQ(experience.images[1].time - experience.images[0].time, std::chrono::milliseconds(1));
  EXPECT_EQ(experience.images[0].name, "a.jpg");
}

TEST_F(ImportedPhotos, FallBackToGpsTimeAndThenToTheOrderOfNames) {
  Tags gps_time = Without("Exif.Photo.DateTimeOriginal");
  gps_time["Exif.GPSInfo.GPSDateStamp"] = "2024:05:01";
  gps_time["Exif.GPSInfo.GPSTimeStamp"] = "10/1 0/1 5/2";
  WritePhoto("b.jpg", gps_time);
  EXPECT_EQ(ToNanoseconds(Import().value().experience.images[0].time), 1714557602'500'000'000);
  WritePhoto("a.jpg", With("Exif.Photo.DateTimeOriginal", "0000:00:00 00:00:00"));
  std::filesystem::remove_all(root_ / "walk");
  const auto import = Import().value();
  EXPECT_EQ(import.times, PhotoTimes::kInvented);
  EXPECT_EQ(import.experience.images[0].name, "a.jpg");
  EXPECT_EQ(ToNanoseconds(import.experience.images[1].time), 1'000'000'000);
}

TEST_F(ImportedPhotos, ShareACameraWhenMakeModelSizeAndFocalLengthAgree) {
  WritePhoto("a.jpg", kFullTags);
  WritePhoto("b.jpg", kFullTags);
  WritePhoto("c.jpg", With("Exif.Image.Model", "Two"));
  WritePhoto("d.jpg", With("Exif.Photo.FocalLengthIn35mmFilm", "50"));
  WritePhoto("e.jpg", kFullTags, 300, 400);
  WritePhoto("f.jpg", Without("Exif.Photo.FocalLengthIn35mmFilm"));
  const auto import = Import().value();
  EXPECT_EQ(import.experience.cameras.size(), 5u);
  EXPECT_EQ(import.photos_with_guessed_focal, 1u);
  EXPECT_EQ(import.experience.cameras.at("cam4").model.FocalX(), 480);
  EXPECT_FALSE(import.experience.cameras.at("cam4").has_known_focal);
}

TEST_F(ImportedPhotos, UseTheSensorWhereItIsPlausible) {
  Tags tags = kFullTags;
  tags["Exif.Photo.FocalLength"] = "18/1";
  tags["Exif.Photo.FocalLengthIn35mmFilm"] = "27";
  tags["Exif.Photo.PixelXDimension"] = "6000";
  tags["Exif.Photo.PixelYDimension"] = "4000";
  tags["Exif.Photo.FocalPlaneXResolution"] = "6000000/925";  // per inch: 23.495 mm wide
  tags["Exif.Photo.FocalPlaneResolutionUnit"] = "2";
  WritePhoto("a.jpg", tags, 600, 400);
  tags["Exif.Photo.FocalPlaneXResolution"] = "72/1";  // the dots of a screen, not of a sensor
  WritePhoto("b.jpg", tags, 600, 400);
  const auto experience = Import().value().experience;
  EXPECT_NEAR(experience.cameras.at("cam0").model.FocalX(), 18 / 23.495 * 600, 1e-6);
  EXPECT_NEAR(experience.cameras.at("cam1").model.FocalX(), 27 / 43.2666 * 721.110, 1e-3);
}

TEST_F(ImportedPhotos, AreNotImportedOverOrIntoEachOther) {
  EXPECT_EQ(Import().error().code, ErrorCode::kNotFound) << "no photo at all";
  EXPECT_EQ(ImportPhotos(root_ / "nowhere", root_ / "walk").error().code, ErrorCode::kNotFound);
  WritePhoto("a.jpg", kFullTags);
  EXPECT_EQ(ImportPhotos(root_ / "photos", root_ / "photos" / "walk").error().code,
            ErrorCode::kInvalidArgument);
  EXPECT_EQ(ImportPhotos(root_ / "photos", root_).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(ImportPhotos(root_ / "photos", root_ / ".hidden").error().code,
            ErrorCode::kInvalidArgument);
  ASSERT_TRUE(Import());
  EXPECT_EQ(Import().error().code, ErrorCode::kConflict);
}

TEST_F(ImportedPhotos, ThatAreDamagedNeverCrashTheReaders) {
  WritePhoto("a.jpg", kFullTags);
  const auto valid = LoadFile(root_ / "photos" / "a.jpg").value();
  std::mt19937 engine(11);
  for (std::size_t i = 0; i < valid.size(); ++i) {
    EXPECT_FALSE(internal::ReadJpegSize(std::span(valid).first(i)));
    (void)internal::ReadPhotoExif(std::span(valid).first(i));
    for (int repeat = 0; repeat < 20; ++repeat) {
      auto damaged = valid;
      damaged[i] = static_cast<std::uint8_t>(engine());
      (void)internal::ReadJpegSize(damaged);
      const auto exif = internal::ReadPhotoExif(damaged);
      EXPECT_TRUE(!exif || !exif->place || exif->place->Validate());
      EXPECT_TRUE(!exif || !exif->time || ToNanoseconds(*exif->time) >= 0);
    }
  }
}

TEST(PhotosOfAStreet, BecomeAnExperience) {
  const char* data = std::getenv("WAYMARK_DATA");
  if (data == nullptr) GTEST_SKIP() << "WAYMARK_DATA names no folder with real recordings";
  const auto folder = std::filesystem::path(testing::TempDir()) / "lund_import";
  std::filesystem::remove_all(folder);
  const auto import = ImportPhotos(std::filesystem::path(data) / "lund", folder);
  ASSERT_TRUE(import) << ToString(import.error());
  EXPECT_EQ(import->experience.images.size(), 29u);
  EXPECT_EQ(import->experience.gnss.size(), 29u);
  EXPECT_EQ(import->experience.cameras.size(), 1u);
  EXPECT_TRUE(import->experience.cameras.at("cam0").has_known_focal);
  EXPECT_TRUE(import->left_out.empty());
  EXPECT_EQ(import->times, PhotoTimes::kInvented) << "these photos were stripped of their times";
  const double length_m =
      GeodesicDistance(import->experience.gnss.front().place, import->experience.gnss.back().place);
  EXPECT_NEAR(length_m, 170, 20);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace waymark::mapping
