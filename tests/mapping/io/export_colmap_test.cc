// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/export_colmap.h"

#include <gmock/gmock.h>

#include <map>
#include <sstream>

#include "tests/mapping/io/export_fixture.h"

namespace waymark::mapping {
namespace {

using ExportColmap = Export;

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

TEST_F(ExportColmap, PointsProjectToTheirPixels) {
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

TEST_F(ExportColmap, ImagesKeepWhatTheySawInEverySubmap) {
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

TEST_F(ExportColmap, BinarySaysTheSameAsText) {
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

}  // namespace
}  // namespace waymark::mapping
