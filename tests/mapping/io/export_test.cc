// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cstring>
#include <map>
#include <sstream>

#include "mapping/base/file.h"
#include "mapping/io/export_colmap.h"
#include "mapping/io/export_points.h"
#include "mapping/io/export_trajectory.h"
#include "tests/mapping/io/export_fixture.h"

namespace waymark::mapping {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST_F(Export, AnImageInTwoSubmapsAppearsOnceWhereItIsNotBorrowed) {
  const auto tum = EncodeTumTrajectory(submaps_);
  ASSERT_TRUE(tum);
  std::vector<std::string> names;
  std::map<std::string, Eigen::Vector3d> positions;
  for (const std::string& line : DataLines(*tum)) {
    std::istringstream in(line);
    std::string name;
    Eigen::Vector3d t;
    in >> name >> t.x() >> t.y() >> t.z();
    names.push_back(name);
    positions[name] = t;
  }
  EXPECT_THAT(names,
              ElementsAre("evening/front/2.jpg", "morning/front/0.jpg", "morning/front/1.jpg",
                          "morning/front/7.jpg", "morning/front/8.jpg"));
  const auto expected =
      CarryPose(submaps_[1].map_from_submap(), second_.images[2].submap_from_camera).translation();
  EXPECT_LT((positions["evening/front/2.jpg"] - expected).norm(), 1e-12);
  const auto in_first = std::span(submaps_).first(1);
  EXPECT_THAT(EncodeTumTrajectory(in_first).value(), HasSubstr("evening/front/2.jpg "))
      << "a borrowed image is shown where nothing else holds it";
}

TEST_F(Export, OneExperienceNeedsNoPrefix) {
  for (SubmapImage& image : first_.images) image.experience = ExperienceId("morning");
  const auto tum = EncodeTumTrajectory(std::span(submaps_).first(1)).value();
  EXPECT_EQ(tum.substr(0, 12), "front/0.jpg ");
}

TEST_F(Export, AViewExportsAsItsModelDoes) {
  const auto path = std::filesystem::path(testing::TempDir()) / "exported_submap";
  ASSERT_TRUE(StoreFileAtomically(path, EncodeSubmap(first_).value()));
  const auto view = SubmapView::Open(path).value();
  const auto decoded = DecodeSubmap(LoadFile(path).value()).value();
  const auto& similarity = submaps_[0].map_from_submap();
  const std::vector<ExportSubmap> from_view{{view, similarity}};
  const std::vector<ExportSubmap> from_model{{decoded, similarity}};
  EXPECT_EQ(EncodeTumTrajectory(from_view).value(), EncodeTumTrajectory(from_model).value());
  EXPECT_EQ(EncodePlyPoints(from_view), EncodePlyPoints(from_model));
  const auto a = EncodeColmap(from_view, ColmapFormat::kBinary).value();
  const auto b = EncodeColmap(from_model, ColmapFormat::kBinary).value();
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(a[i].content, b[i].content);
  std::filesystem::remove(path);
}

TEST_F(Export, PlyHoldsEveryLandmarkInTheMapFrame) {
  const std::string ply = EncodePlyPoints(submaps_);
  EXPECT_THAT(ply, HasSubstr("element vertex 80\n"));
  const std::size_t header = ply.find("end_header\n") + 11;
  ASSERT_EQ(ply.size(), header + 80 * 28);
  Eigen::Vector3d last;
  std::memcpy(last.data(), ply.data() + ply.size() - 28, 24);
  const auto expected = submaps_[1].map_from_submap() * second_.landmarks.back();
  EXPECT_EQ(last, expected.coordinates());
}

TEST_F(Export, NamesThatTextCannotSpellAreNamed) {
  first_.images[0].name = "front/IMG 1.jpg";
  const auto text = EncodeColmap(submaps_, ColmapFormat::kText);
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(text.error().message, HasSubstr("IMG 1.jpg"));
  EXPECT_FALSE(EncodeTumTrajectory(submaps_));
  EXPECT_TRUE(EncodeColmap(submaps_, ColmapFormat::kBinary));
}

TEST_F(Export, NothingGivesEmptyFiles) {
  EXPECT_EQ(EncodeTumTrajectory({}).value(), "");
  EXPECT_EQ(EncodeColmap({}, ColmapFormat::kBinary).value()[0].content.size(), 8u);
  EXPECT_THAT(EncodePlyPoints({}), HasSubstr("element vertex 0\n"));
}

TEST_F(Export, FilesAreWrittenIntoANewFolder) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "colmap_export" / "sparse";
  const auto files = EncodeColmap(submaps_, ColmapFormat::kText).value();
  ASSERT_TRUE(StoreExport(files, folder));
  EXPECT_EQ(LoadTextFile(folder / "images.txt").value(), files[1].content);
  std::filesystem::remove_all(folder.parent_path());
}

}  // namespace
}  // namespace waymark::mapping
