// SPDX-License-Identifier: Apache-2.0
// What other programs, and our own readers, make of our exports.
#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "mapping/base/file.h"
#include "mapping/base/process.h"
#include "mapping/experience/import_colmap.h"
#include "mapping/experience/kapture.h"
#include "mapping/io/export_colmap.h"
#include "mapping/io/export_geojson.h"
#include "mapping/io/export_kapture.h"
#include "tests/mapping/io/example_submap.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A submap in a turned and scaled place, and a folder that goes with the test.
class OtherPrograms : public testing::Test {
 protected:
  OtherPrograms()
      : folder_(fs::path(testing::TempDir()) / fmt::format("other_programs_{}", ::getpid())) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    for (SubmapImage& image : model_.images) image.experience = ExperienceId("morning");
  }
  ~OtherPrograms() override { fs::remove_all(folder_); }

  std::vector<ExportSubmap> Submaps() const {
    return {{model_, Similarity<Map, Submap>(Sim3(1.1, RotationFromVector({0.1, 0.2, 0.3}),
                                                  Eigen::Vector3d(100, -50, 3)))}};
  }

  /// Empty files under the names of the images.
  void MakeImages(const fs::path& folder) const {
    for (const SubmapImage& image : model_.images) {
      fs::create_directories((folder / image.name).parent_path());
      std::ofstream(folder / image.name) << "picture";
    }
  }

  fs::path folder_;
  SubmapModel model_ = ExampleSubmap(7, 40);
};

void ExpectSamePoses(const Experience& experience, const std::vector<ExportSubmap>& submaps) {
  const auto images = submaps[0].images();
  ASSERT_EQ(experience.images.size(), images.size());
  ASSERT_EQ(experience.trajectory.size(), images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    EXPECT_EQ(experience.images[i].name, images[i].name);
    EXPECT_EQ(experience.images[i].time, experience.trajectory[i].time);
    const auto pose = CarryPose(submaps[0].map_from_submap(), images[i].submap_from_camera);
    EXPECT_THAT(experience.trajectory[i].device_from_world.Inverse(), support::Near(pose.rigid()));
    EXPECT_EQ(experience.cameras.at(experience.images[i].camera).model,
              submaps[0].cameras()[images[i].camera]);
  }
}

TEST_F(OtherPrograms, KaptureReadsItsExport) {
  const auto submaps = Submaps();
  ASSERT_TRUE(StoreKaptureExport(submaps, folder_ / "out").ok());
  MakeImages(folder_ / "out" / "sensors" / "records_data");
  const auto experience = LoadKapture(folder_ / "out");
  ASSERT_TRUE(experience.ok()) << ToString(experience.error());
  ExpectSamePoses(*experience, submaps);
  const auto points = LoadTextFile(folder_ / "out" / "reconstruction" / "points3d.txt");
  EXPECT_EQ(std::ranges::count(*points, '\n'), 2 + 40);
}

TEST_F(OtherPrograms, ColmapModelsComeBackTextOrBinary) {
  const auto submaps = Submaps();
  MakeImages(folder_ / "images");
  for (const ColmapFormat format : {ColmapFormat::kText, ColmapFormat::kBinary}) {
    const std::string name = format == ColmapFormat::kText ? "text" : "binary";
    ASSERT_TRUE(StoreExport(*EncodeColmap(submaps, format), folder_ / name / "model").ok());
    const auto import =
        ImportColmap(folder_ / name / "model", folder_ / "images", folder_ / name / "drive");
    ASSERT_TRUE(import.ok()) << ToString(import.error());
    EXPECT_TRUE(import->missing.empty());
    ExpectSamePoses(import->experience, submaps);
  }
}

TEST_F(OtherPrograms, ColmapImagesWithoutFilesAreNamed) {
  ASSERT_TRUE(StoreExport(*EncodeColmap(Submaps(), ColmapFormat::kBinary), folder_ / "model").ok());
  fs::create_directories(folder_ / "images");
  const auto none = ImportColmap(folder_ / "model", folder_ / "images", folder_ / "drive");
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::kNotFound);
  MakeImages(folder_ / "images");
  fs::remove(folder_ / "images" / model_.images[1].name);
  const auto some = ImportColmap(folder_ / "model", folder_ / "images", folder_ / "drive");
  ASSERT_TRUE(some.ok()) << ToString(some.error());
  EXPECT_THAT(some->missing, testing::ElementsAre(model_.images[1].name));
  EXPECT_EQ(some->experience.images.size(), model_.images.size() - 1);
}

TEST_F(OtherPrograms, HostileColmapModelsAreErrors) {
  MakeImages(folder_ / "images");
  const auto files = *EncodeColmap(Submaps(), ColmapFormat::kBinary);
  for (const std::size_t file : {0u, 1u}) {
    const std::string& whole = files[file].content;
    for (std::size_t size = 0; size < std::min<std::size_t>(whole.size(), 400); size += 3) {
      ASSERT_TRUE(StoreExport(files, folder_ / "model").ok());
      ASSERT_TRUE(StoreFileAtomically(folder_ / "model" / files[file].name,
                                      std::string_view(whole).substr(0, size))
                      .ok());
      const auto import = ImportColmap(folder_ / "model", folder_ / "images", folder_ / "drive");
      ASSERT_FALSE(import.ok()) << files[file].name << " of " << size << " bytes";
      EXPECT_THAT(import.error().message, HasSubstr(files[file].name));
    }
  }
}

TEST_F(OtherPrograms, WrongLinesAreNamed) {
  fs::create_directories(folder_ / "model");
  const auto fail = [&](std::string_view cameras, std::string_view images) {
    std::ofstream(folder_ / "model/cameras.txt") << cameras;
    std::ofstream(folder_ / "model/images.txt") << images;
    return ImportColmap(folder_ / "model", folder_ / "images", folder_ / "drive").error();
  };
  constexpr std::string_view kCamera = "# comment\n1 PINHOLE 640 480 500 500 320 240\n";
  EXPECT_THAT(fail("1 FISHEYE 640 480 1 2 3 4\n", "").message, HasSubstr("cameras.txt:1"));
  EXPECT_THAT(fail("1 PINHOLE 640 480 500\n", "").message, HasSubstr("camera's parameters"));
  EXPECT_THAT(fail(kCamera, "1 2 0 0 0 1 2 3 1 a.jpg\n\n").message, HasSubstr("length 1"));
  EXPECT_THAT(fail(kCamera, "1 1 0 0 0 1 2 3 9 a.jpg\n\n").message, HasSubstr("its cameras"));
  EXPECT_THAT(fail(kCamera, "1 1 0 0 0 1 2 3 1 ../a.jpg\n\n").message, HasSubstr("relative path"));
  EXPECT_THAT(fail(kCamera, "1 1 0 0 0 1 2 3 1 a.jpg\n\n2 1 0 0 0 1 2 3 1 a.jpg\n\n").message,
              HasSubstr("different names"));
  EXPECT_THAT(fail(kCamera, "").message, HasSubstr("none"));
}

TEST_F(OtherPrograms, ColmapAnalysesItsExport) {
  const auto asked = CaptureProgram({"colmap", "help"});
  if (!asked.ok()) GTEST_SKIP() << "COLMAP is not installed";
  for (const ColmapFormat format : {ColmapFormat::kText, ColmapFormat::kBinary}) {
    ASSERT_TRUE(StoreExport(*EncodeColmap(Submaps(), format), folder_ / "model").ok());
    const auto outcome =
        CaptureProgram({"colmap", "model_analyzer", "--path", (folder_ / "model").string()});
    ASSERT_TRUE(outcome.ok());
    EXPECT_EQ(outcome->status, 0) << outcome->output;
    EXPECT_THAT(outcome->output, HasSubstr("Registered images: 3"));
    EXPECT_THAT(outcome->output, HasSubstr("Points: 40"));
    fs::remove_all(folder_ / "model");
  }
}

TEST_F(OtherPrograms, GeoJsonPutsSubmapsAndImagesOnTheEarth) {
  const GeoPoint origin{Angle::Degrees(48), Angle::Degrees(11), 500};
  const std::vector<GeoSubmap> submaps{{SubmapId("0123456789abcdef0123456789abcdef"), Submaps()[0],
                                        Point<Map>(Eigen::Vector3d(100, 0, 0)), 25}};
  const auto json = nlohmann::json::parse(EncodeGeoJson(submaps, origin));
  ASSERT_EQ(json["type"], "FeatureCollection");
  ASSERT_EQ(json["features"].size(), 1 + model_.images.size());
  const auto& disc = json["features"][0];
  const auto& ring = disc["geometry"]["coordinates"][0];
  EXPECT_EQ(ring.front(), ring.back()) << "a closed ring";
  EXPECT_EQ(disc["properties"]["images"], 3);
  const TangentPlane plane(origin);
  for (const auto& corner : ring) {
    const Point<Map> place = plane.ToMap(
        {Angle::Degrees(corner[1].get<double>()), Angle::Degrees(corner[0].get<double>()), 500});
    EXPECT_NEAR((place.coordinates() - Eigen::Vector3d(100, 0, 0)).head<2>().norm(), 25, 0.01);
  }
  const auto& image = json["features"][1];
  EXPECT_EQ(image["geometry"]["type"], "Point");
  EXPECT_EQ(image["properties"]["name"], "front/0.jpg");
  EXPECT_EQ(image["properties"]["experience"], "morning");
}

}  // namespace
}  // namespace waymark::mapping
