// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

#include "mapping/base/file.h"
#include "mapping/io/export_colmap.h"
#include "mapping/io/export_points.h"
#include "mapping/io/export_trajectory.h"
#include "tests/mapping/io/example_submap.h"

namespace waymark::mapping {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A submap in which every observation is where its landmark projects.
SubmapModel ConsistentSubmap(std::uint64_t seed) {
  SubmapModel model = ExampleSubmap(seed, 40);
  support::RandomGeometry random(seed);
  for (SubmapImage& image : model.images) {
    image.submap_from_camera = Transform<Submap, Camera>(RotationFromVector(random.Vector(0.1)),
                                                         Eigen::Vector3d(random.Vector(1)));
  }
  for (auto& landmark : model.landmarks) {
    landmark = Point<Submap>(random.Vector(3) + Eigen::Vector3d(0, 0, 12));
  }
  for (LandmarkObservation& observation : model.observations) {
    const SubmapImage& image = model.images[observation.image];
    const auto x_in_camera =
        image.submap_from_camera.Inverse() * model.landmarks[observation.landmark];
    const auto pixel = model.cameras[image.camera].Project(x_in_camera.coordinates()).value();
    observation.x_px = static_cast<float>(pixel.x());
    observation.y_px = static_cast<float>(pixel.y());
  }
  return model;
}

/// A COLMAP text model as read back by the rules of its own documentation.
struct ReadBack {
  struct Image {
    Rigid3 camera_from_world;
    int camera;
    std::string name;
    std::vector<std::pair<Eigen::Vector2d, int>> pixels;
  };
  std::map<int, CameraModel> cameras;
  std::map<int, Image> images;
  std::map<int, Eigen::Vector3d> points;
  std::map<int, std::vector<std::pair<int, int>>> tracks;
  double worst_error_px = 0;
};

std::vector<std::string> DataLines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] != '#') lines.push_back(line);
  }
  return lines;
}

ReadBack Read(const std::vector<ExportFile>& files) {
  ReadBack model;
  for (const std::string& line : DataLines(files[0].content)) {
    std::istringstream in(line);
    int id = 0, width = 0, height = 0;
    std::string kind;
    in >> id >> kind >> width >> height;
    std::vector<double> parameters;
    for (double parameter; in >> parameter;) parameters.push_back(parameter);
    const auto camera =
        CameraModel::Create(FindCameraKind(kind).value(), width, height, parameters);
    model.cameras.emplace(id, camera.value());
  }
  const auto lines = DataLines(files[1].content);
  for (std::size_t i = 0; i + 1 < lines.size(); i += 2) {
    std::istringstream in(lines[i]);
    int id = 0;
    Eigen::Quaterniond q;
    Eigen::Vector3d t;
    ReadBack::Image image;
    in >> id >> q.w() >> q.x() >> q.y() >> q.z() >> t.x() >> t.y() >> t.z() >> image.camera >>
        image.name;
    image.camera_from_world = Rigid3(q, t);
    std::istringstream pixels(lines[i + 1]);
    double x = 0, y = 0;
    for (int point = 0; pixels >> x >> y >> point;) image.pixels.push_back({{x, y}, point});
    model.images.emplace(id, image);
  }
  for (const std::string& line : DataLines(files[2].content)) {
    std::istringstream in(line);
    int id = 0, rgb = 0, image = 0, pixel = 0;
    double error_px = 0;
    Eigen::Vector3d x;
    in >> id >> x.x() >> x.y() >> x.z() >> rgb >> rgb >> rgb >> error_px;
    model.points.emplace(id, x);
    model.worst_error_px = std::max(model.worst_error_px, error_px);
    while (in >> image >> pixel) model.tracks[id].emplace_back(image, pixel);
  }
  return model;
}

class Export : public testing::Test {
 protected:
  Export() : first_(ConsistentSubmap(1)), second_(ConsistentSubmap(2)) {
    // Image 2 of the first is borrowed; the second owns it. Its own image 2 is elsewhere.
    second_.images[2].is_borrowed = false;
    second_.images[0].name = "front/7.jpg";
    second_.images[1].name = "front/8.jpg";
    support::RandomGeometry random(5);
    submaps_ = {ExportSubmap(first_, Similarity<Map, Submap>(random.Similarity())),
                ExportSubmap(second_, Similarity<Map, Submap>(random.Similarity()))};
  }

  SubmapModel first_;
  SubmapModel second_;
  std::vector<ExportSubmap> submaps_;
};

TEST_F(Export, ColmapPointsProjectToTheirPixels) {
  const auto one = std::span(submaps_).first(1);
  const auto files = EncodeColmap(one, ColmapFormat::kText);
  ASSERT_TRUE(files) << ToString(files.error());
  const ReadBack model = Read(*files);
  EXPECT_EQ(model.cameras.size(), 2u);
  EXPECT_EQ(model.images.size(), 3u);
  EXPECT_EQ(model.points.size(), 40u);
  EXPECT_LT(model.worst_error_px, 1e-4);
  std::size_t pixel_count = 0;
  for (const auto& [id, image] : model.images) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const auto& [pixel, point] = image.pixels[i];
      const auto projected =
          model.cameras.at(image.camera).Project(image.camera_from_world * model.points.at(point));
      ASSERT_TRUE(projected);
      EXPECT_LT((*projected - pixel).norm(), 1e-3);
      EXPECT_THAT(model.tracks.at(point), testing::Contains(std::pair(id, static_cast<int>(i))));
      ++pixel_count;
    }
  }
  EXPECT_EQ(pixel_count, first_.observations.size());
}

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

TEST_F(Export, ColmapImagesKeepWhatTheySawInEverySubmap) {
  const ReadBack model = Read(EncodeColmap(submaps_, ColmapFormat::kText).value());
  EXPECT_EQ(model.images.size(), 5u);
  EXPECT_EQ(model.points.size(), 80u);
  std::size_t sightings = 0;
  for (const auto& [id, track] : model.tracks) sightings += track.size();
  EXPECT_EQ(sightings, first_.observations.size() + second_.observations.size());
}

template <typename T>
T Take(std::istream& in) {
  T value{};
  in.read(reinterpret_cast<char*>(&value), sizeof(T));
  return value;
}

TEST_F(Export, ColmapBinarySaysTheSameAsText) {
  const ReadBack text = Read(EncodeColmap(submaps_, ColmapFormat::kText).value());
  const auto files = EncodeColmap(submaps_, ColmapFormat::kBinary).value();
  std::istringstream cameras(files[0].content);
  ASSERT_EQ(Take<std::uint64_t>(cameras), text.cameras.size());
  EXPECT_EQ(Take<std::uint32_t>(cameras), 1u);
  EXPECT_EQ(Take<std::int32_t>(cameras), static_cast<int>(text.cameras.at(1).kind()));
  EXPECT_EQ(Take<std::uint64_t>(cameras), text.cameras.at(1).width_px());
  std::istringstream images(files[1].content);
  ASSERT_EQ(Take<std::uint64_t>(images), text.images.size());
  for (const auto& [id, image] : text.images) {
    EXPECT_EQ(Take<std::uint32_t>(images), static_cast<std::uint32_t>(id));
    EXPECT_NEAR(Take<double>(images), image.camera_from_world.rotation().w(), 1e-15);
    for (int i = 0; i < 3; ++i) Take<double>(images);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(Take<double>(images), image.camera_from_world.translation()[i]);
    }
    EXPECT_EQ(Take<std::uint32_t>(images), static_cast<std::uint32_t>(image.camera));
    std::string name;
    std::getline(images, name, '\0');
    EXPECT_EQ(name, image.name);
    ASSERT_EQ(Take<std::uint64_t>(images), image.pixels.size());
    for (const auto& [pixel, point] : image.pixels) {
      EXPECT_EQ(static_cast<float>(Take<double>(images)), static_cast<float>(pixel.x()));
      EXPECT_EQ(static_cast<float>(Take<double>(images)), static_cast<float>(pixel.y()));
      EXPECT_EQ(Take<std::uint64_t>(images), static_cast<std::uint64_t>(point));
    }
  }
  std::istringstream points(files[2].content);
  ASSERT_EQ(Take<std::uint64_t>(points), text.points.size());
  for (const auto& [id, position] : text.points) {
    EXPECT_EQ(Take<std::uint64_t>(points), static_cast<std::uint64_t>(id));
    for (int i = 0; i < 3; ++i) EXPECT_EQ(Take<double>(points), position[i]);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(Take<std::uint8_t>(points), 128);
    Take<double>(points);
    ASSERT_EQ(Take<std::uint64_t>(points), text.tracks.at(id).size());
    for (const auto& [image, pixel] : text.tracks.at(id)) {
      EXPECT_EQ(Take<std::uint32_t>(points), static_cast<std::uint32_t>(image));
      EXPECT_EQ(Take<std::uint32_t>(points), static_cast<std::uint32_t>(pixel));
    }
  }
  EXPECT_EQ(points.peek(), EOF);
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
