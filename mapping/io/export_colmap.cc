// SPDX-License-Identifier: Apache-2.0
#include "mapping/io/export_colmap.h"

#include <fmt/format.h>

#include <array>
#include <iterator>

#include "mapping/io/internal/binary_text.h"
#include "mapping/io/internal/colmap_model.h"
#include "mapping/io/internal/export_images.h"

namespace waymark::mapping {
namespace {

using internal::AppendBinary;
using internal::ColmapModel;

constexpr std::array<std::uint8_t, 3> kGrey{128, 128, 128};

/// qw, qx, qy, qz, tx, ty, tz.
std::array<double, 7> PoseNumbers(const Transform<Camera, Map>& camera_from_map) {
  const auto& q = camera_from_map.rotation();
  const auto& t = camera_from_map.translation();
  return {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
}

std::string CamerasAsText(const ColmapModel& model) {
  std::string text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  const auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    const CameraModel& camera = model.cameras[i];
    fmt::format_to(out, "{} {} {} {}", i + 1, CameraKindName(camera.kind()), camera.width_px(),
                   camera.height_px());
    for (const double parameter : camera.parameters()) fmt::format_to(out, " {}", parameter);
    text += '\n';
  }
  return text;
}

std::string ImagesAsText(const ColmapModel& model) {
  std::string text =
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, "
      "POINT3D_ID)\n";
  const auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const ColmapModel::Image& image = model.images[i];
    fmt::format_to(out, "{}", i + 1);
    for (const double number : PoseNumbers(image.camera_from_map)) {
      fmt::format_to(out, " {}", number);
    }
    fmt::format_to(out, " {} {}\n", image.camera + 1, image.name);
    for (const auto& pixel : image.pixels) {
      fmt::format_to(out, "{} {} {} ", pixel.x_px, pixel.y_px, pixel.point + 1);
    }
    text += '\n';
  }
  return text;
}

std::string PointsAsText(const ColmapModel& model) {
  std::string text = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  const auto out = std::back_inserter(text);
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const ColmapModel::SeenPoint& point = model.points[i];
    const auto& x = point.position_in_map;
    fmt::format_to(out, "{} {} {} {} {} {} {} {}", i + 1, x.x(), x.y(), x.z(), kGrey[0], kGrey[1],
                   kGrey[2], point.error_px);
    for (const auto& sighting : point.track) {
      fmt::format_to(out, " {} {}", sighting.image + 1, sighting.pixel);
    }
    text += '\n';
  }
  return text;
}

std::string CamerasAsBinary(const ColmapModel& model) {
  std::string bytes;
  AppendBinary(bytes, std::uint64_t{model.cameras.size()});
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    const CameraModel& camera = model.cameras[i];
    AppendBinary(bytes, static_cast<std::uint32_t>(i + 1));
    AppendBinary(bytes, static_cast<std::int32_t>(camera.kind()));  // numbered as COLMAP does
    AppendBinary(bytes, static_cast<std::uint64_t>(camera.width_px()));
    AppendBinary(bytes, static_cast<std::uint64_t>(camera.height_px()));
    for (const double parameter : camera.parameters()) AppendBinary(bytes, parameter);
  }
  return bytes;
}

std::string ImagesAsBinary(const ColmapModel& model) {
  std::string bytes;
  AppendBinary(bytes, std::uint64_t{model.images.size()});
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const ColmapModel::Image& image = model.images[i];
    AppendBinary(bytes, static_cast<std::uint32_t>(i + 1));
    for (const double number : PoseNumbers(image.camera_from_map)) AppendBinary(bytes, number);
    AppendBinary(bytes, image.camera + 1);
    bytes += image.name;
    bytes += '\0';
    AppendBinary(bytes, std::uint64_t{image.pixels.size()});
    for (const auto& pixel : image.pixels) {
      AppendBinary(bytes, pixel.x_px);
      AppendBinary(bytes, pixel.y_px);
      AppendBinary(bytes, pixel.point + 1);
    }
  }
  return bytes;
}

std::string PointsAsBinary(const ColmapModel& model) {
  std::string bytes;
  AppendBinary(bytes, std::uint64_t{model.points.size()});
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const ColmapModel::SeenPoint& point = model.points[i];
    AppendBinary(bytes, std::uint64_t{i + 1});
    for (const double component : point.position_in_map) AppendBinary(bytes, component);
    for (const std::uint8_t channel : kGrey) AppendBinary(bytes, channel);
    AppendBinary(bytes, point.error_px);
    AppendBinary(bytes, std::uint64_t{point.track.size()});
    for (const auto& sighting : point.track) {
      AppendBinary(bytes, sighting.image + 1);
      AppendBinary(bytes, sighting.pixel);
    }
  }
  return bytes;
}

}  // namespace

Result<std::vector<ExportFile>> EncodeColmap(std::span<const ExportSubmap> submaps,
                                             ColmapFormat format) {
  if (format == ColmapFormat::kText) {
    WAYMARK_TRY(internal::CheckNamesHaveNoBlanks(internal::MergeImages(submaps), "COLMAP text"));
  }
  const ColmapModel model = internal::MakeColmapModel(submaps);
  if (format == ColmapFormat::kText) {
    return std::vector<ExportFile>{{"cameras.txt", CamerasAsText(model)},
                                   {"images.txt", ImagesAsText(model)},
                                   {"points3D.txt", PointsAsText(model)}};
  }
  return std::vector<ExportFile>{{"cameras.bin", CamerasAsBinary(model)},
                                 {"images.bin", ImagesAsBinary(model)},
                                 {"points3D.bin", PointsAsBinary(model)}};
}

}  // namespace waymark::mapping
