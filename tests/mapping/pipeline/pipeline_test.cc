// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/pipeline.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <set>

#include "mapping/base/file.h"
#include "mapping/io/submap_file.h"
#include "mapping/pipeline/inspect.h"
#include "mapping/store/map_directory.h"
#include "tests/mapping/pipeline/facade.h"

namespace waymark::mapping {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class Pipeline : public testing::Test {
 protected:
  Pipeline()
      : folder_(fs::path(testing::TempDir()) /
                fmt::format("pipeline_{}_{}", getpid(),
                            testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~Pipeline() override { fs::remove_all(folder_); }

  AddRequest Request(std::vector<std::string> experiences) const {
    AddRequest request{.map_folder = Map(), .created_utc = "2026-01-02T03:04:05Z"};
    for (const std::string& name : experiences)
      request.experience_folders.push_back(folder_ / name);
    request.options.features.max_features = 1500;
    return request;
  }

  fs::path Map() const { return folder_ / "map"; }

  Result<AddReport> Add(std::vector<std::string> experiences) const {
    return AddExperiences(Request(std::move(experiences)));
  }

  /// The worst distance of a released camera to its truth.
  double WorstError(const FacadeTruth& truth, const std::string& experience) const {
    const auto map = *MapDirectory::Open(Map());
    const TangentPlane truth_plane(StreetOrigin());
    const TangentPlane map_plane(map.description().origin);
    double worst_m = 0;
    const Release release = *map.LoadCurrentRelease();
    for (const ReleasedSubmap& submap : release.submaps) {
      const auto view = *SubmapView::Open(map.SubmapPath(submap.id));
      for (const SubmapImage& image : view.images()) {
        if (image.experience.text() != experience) continue;
        const Point<waymark::Map> found(submap.map_from_submap.sim() *
                                        image.submap_from_camera.translation());
        const Eigen::Vector3d in_truth = truth_plane.ToMap(map_plane.ToGeo(found)).coordinates();
        worst_m = std::max(worst_m, (in_truth - truth.at(image.name).translation()).norm());
      }
    }
    return worst_m;
  }

  fs::path folder_;
};

TEST_F(Pipeline, ADriveBecomesAReleaseAtItsPlace) {
  const FacadeTruth truth = MakeFacadeDrive(folder_ / "drive", {.images = 12});
  const auto report = Add({"drive"});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->added, SizeIs(1));
  EXPECT_EQ(report->epoch, 1u);
  EXPECT_TRUE(report->is_geo_aligned);
  EXPECT_THAT(report->left_out, IsEmpty());
  ASSERT_THAT(report->submaps, SizeIs(1));
  EXPECT_EQ(report->submaps[0].images, 12);
  EXPECT_THAT(report->submaps[0].verdict, HasSubstr("gyroscope within 0.00"));
  EXPECT_LT(WorstError(truth, "drive"), 0.1);
}

TEST_F(Pipeline, AddingTheSameAgainSaysSoAndDoesNothing) {
  MakeFacadeDrive(folder_ / "drive", {});
  ASSERT_TRUE(Add({"drive"}).ok());
  const auto again = Add({"drive"});
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_THAT(again->already_in_map, SizeIs(1));
  EXPECT_FALSE(again->epoch.has_value());
  EXPECT_EQ(*MapDirectory::Open(Map())->LoadCurrentEpoch(), 1u);
}

TEST_F(Pipeline, OverlappingHalvesAreFused) {
  const FacadeTruth truth = MakeFacadeDrive(folder_ / "drive", {.images = 20, .gnss_noise_m = 0.1});
  AddRequest request = Request({"drive"});
  request.options.split =
      SplitOptions{.radius_m = 5, .min_radius_m = 4, .overlap_m = 4, .min_images = 5};
  const auto report = AddExperiences(request);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_GE(report->submaps.size(), 2u);
  EXPECT_THAT(report->left_out, IsEmpty());
  EXPECT_GT(report->overlap_rms_m, 0);
  EXPECT_LT(report->overlap_rms_m, 0.1);
  EXPECT_LT(WorstError(truth, "drive"), 0.25);
}

TEST_F(Pipeline, ASecondDriveBorrowsFromTheFirst) {
  const FacadeTruth first = MakeFacadeDrive(folder_ / "first", {.images = 10});
  const FacadeTruth second = MakeFacadeDrive(
      folder_ / "second", {.images = 10, .first_m = 0.3, .aside_m = 0.5, .seed = 2});
  ASSERT_TRUE(Add({"first"}).ok());
  const auto report = Add({"second"});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->epoch, 2u);
  const auto release = *MapDirectory::Open(Map())->LoadCurrentRelease();
  EXPECT_EQ(release.parent_epoch, 1u);
  ASSERT_THAT(release.submaps, SizeIs(2));
  EXPECT_GT(report->submaps[0].images, 12) << "own images and borrowed ones";
  EXPECT_LT(report->overlap_rms_m, 0.05);
  EXPECT_LT(WorstError(first, "first"), 0.1);
  EXPECT_LT(WorstError(second, "second"), 0.1);
}

TEST_F(Pipeline, WithoutGnssTheMapIsLocalAndSaysSo) {
  MakeFacadeDrive(folder_ / "drive", {.has_gnss = false, .has_imu = false});
  const auto report = Add({"drive"});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_FALSE(report->is_geo_aligned);
  EXPECT_FALSE(MapDirectory::Open(Map())->description().is_geo_aligned);
  EXPECT_EQ(report->epoch, 1u);
}

TEST_F(Pipeline, ImagesThatDoNotOverlapAreRefusedWithReasons) {
  MakeFacadeDrive(folder_ / "drive", {.images = 4, .step_m = 30, .has_imu = false});
  AddRequest request = Request({"drive"});
  request.options.split.max_radius_m = 200;
  const auto report = AddExperiences(request);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->rejected, SizeIs(1));
  EXPECT_FALSE(report->epoch.has_value());
  EXPECT_THAT(report->left_out, SizeIs(4));
  for (const LeftOutImage& image : report->left_out) EXPECT_THAT(image.reason, Not(IsEmpty()));
  EXPECT_FALSE(MapDirectory::Open(Map())->LoadCurrentEpoch()->has_value());
}

TEST_F(Pipeline, AnUndecodableImageIsLeftOut) {
  MakeFacadeDrive(folder_ / "drive", {});
  std::ofstream(folder_ / "drive/sensors/records_data/0004.png") << "no picture";
  const auto report = Add({"drive"});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->epoch, 1u);
  ASSERT_THAT(report->left_out, SizeIs(1));
  EXPECT_EQ(report->left_out[0].name, "0004.png");
  EXPECT_THAT(report->left_out[0].reason, HasSubstr("corrupt"));
  EXPECT_EQ(InspectExperiences(Map())->at(0).unusable, 1u);
}

TEST_F(Pipeline, PicturesOfACameraThatHangsAreLeftOut) {
  MakeFacadeDrive(folder_ / "drive", {});
  const fs::path pictures = folder_ / "drive/sensors/records_data";
  for (const char* name : {"0004.png", "0005.png"}) {
    fs::copy_file(pictures / "0003.png", pictures / name, fs::copy_options::overwrite_existing);
  }
  const auto report = Add({"drive"});
  ASSERT_TRUE(report.ok()) << report.error().message;
  ASSERT_THAT(report->left_out, SizeIs(2));
  EXPECT_EQ(report->left_out[0].name, "0004.png");
  EXPECT_THAT(report->left_out[1].reason, HasSubstr("the same picture as 0004.png"));
}

TEST_F(Pipeline, AMissingImageOrAWrongLineIsOneErrorAndNoMap) {
  MakeFacadeDrive(folder_ / "drive", {.images = 3});
  fs::remove(folder_ / "drive/sensors/records_data/0001.png");
  const auto missing = Add({"drive"});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, HasSubstr("0001.png"));
  MakeFacadeDrive(folder_ / "other", {.images = 3});
  std::ofstream(folder_ / "other/sensors/records_camera.txt", std::ios::app)
      << "soon, cam0, x.png\n";
  const auto wrong = Add({"other"});
  ASSERT_FALSE(wrong.ok());
  EXPECT_EQ(wrong.error().code, ErrorCode::kCorrupt);
  EXPECT_THAT(wrong.error().message, HasSubstr("records_camera.txt:"));
  EXPECT_FALSE(fs::exists(Map()));
}

TEST_F(Pipeline, OtherContentUnderAKnownNameIsAConflict) {
  MakeFacadeDrive(folder_ / "drive", {.images = 8});
  ASSERT_TRUE(Add({"drive"}).ok());
  MakeFacadeDrive(folder_ / "drive", {.images = 9});
  const auto report = Add({"drive"});
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kConflict);
}

TEST_F(Pipeline, AMapOfAnotherVersionIsRefused) {
  MakeFacadeDrive(folder_ / "drive", {.images = 8});
  AddRequest request = Request({"drive"});
  request.until = AddUntil::kPlan;
  ASSERT_TRUE(AddExperiences(request).ok());
  std::string text = *LoadTextFile(Map() / "map.json");
  const auto digit = text.find_first_of("0123456789", text.find("version"));
  ASSERT_NE(digit, std::string::npos) << text;
  text[digit] = '9';
  ASSERT_TRUE(StoreFileAtomically(Map() / "map.json", std::string_view(text)).ok());
  const auto report = Add({"drive"});
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kUnsupported);
}

TEST_F(Pipeline, PlannedSubmapsAreBuiltApartAndAddOnlyFusesThem) {
  MakeFacadeDrive(folder_ / "drive", {});
  AddRequest request = Request({"drive"});
  request.until = AddUntil::kPlan;
  const auto planned = AddExperiences(request);
  ASSERT_TRUE(planned.ok()) << planned.error().message;
  ASSERT_THAT(planned->submaps, SizeIs(1));
  EXPECT_FALSE(planned->epoch.has_value());
  const std::string& task = planned->submaps[0].task;
  const auto built = BuildSubmap(Map(), task, {});
  ASSERT_TRUE(built.ok()) << built.error().message;
  EXPECT_FALSE(built->was_built_before);
  EXPECT_TRUE(BuildSubmap(Map(), task, {})->was_built_before);
  const auto report = Add({"drive"});
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->epoch, 1u);
  EXPECT_TRUE(report->submaps[0].was_built_before);
  EXPECT_EQ(BuildSubmap(Map(), "nosuch", {}).error().code, ErrorCode::kNotFound);
}

TEST_F(Pipeline, RefusesNoAndEqualExperiences) {
  MakeFacadeDrive(folder_ / "drive", {.images = 3});
  EXPECT_EQ(Add({}).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(Add({"drive", "drive"}).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(Add({"nowhere"}).error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace waymark::mapping
