// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/internal/colmap_poses.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mapping/experience/internal/colmap_source.h"
#include "mapping/experience/internal/kapture_table.h"
#include "mapping/experience/names.h"

namespace waymark::mapping::internal {
namespace {

Result<Rigid3> ReadPose(ColmapSource& source) {
  std::array<double, 7> numbers{};
  for (double& number : numbers) {
    WAYMARK_TRY_ASSIGN(number, source.Number("a pose of seven numbers"));
  }
  const auto& [qw, qx, qy, qz, tx, ty, tz] = numbers;
  const Eigen::Quaterniond q(qw, qx, qy, qz);
  if (!(std::abs(q.norm() - 1) < 1e-3)) return source.Wrong("a quaternion of length 1");
  return Rigid3(q.normalized(), {tx, ty, tz});
}

Result<void> ReadCameras(ColmapSource& source, ColmapPoses& poses) {
  while (true) {
    WAYMARK_TRY_ASSIGN(const bool has_more, source.Next());
    if (!has_more) return {};
    WAYMARK_TRY_ASSIGN(const std::int64_t id, source.Integer("a camera's id"));
    WAYMARK_TRY_ASSIGN(const CameraKind kind, source.Kind());
    WAYMARK_TRY_ASSIGN(const std::int64_t width, source.Integer("a width"));
    WAYMARK_TRY_ASSIGN(const std::int64_t height, source.Integer("a height"));
    std::array<double, 8> parameters{};
    const auto used = std::span(parameters).first(ParameterCount(kind));
    for (double& parameter : used) {
      WAYMARK_TRY_ASSIGN(parameter, source.Number("a camera's parameters"));
    }
    constexpr std::int64_t kMaxSide = 1 << 20;
    const bool is_in_range = id >= 0 && id <= UINT32_MAX && width >= 0 && width <= kMaxSide &&
                             height >= 0 && height <= kMaxSide;
    const auto camera =
        is_in_range
            ? CameraModel::Create(kind, static_cast<int>(width), static_cast<int>(height), used)
            : Result<CameraModel>(source.Wrong("an id and a size in range"));
    if (!camera) {
      return MakeError(ErrorCode::kCorrupt, "{}: {}", source.Where(), camera.error().message);
    }
    if (!poses.cameras.emplace(static_cast<std::uint32_t>(id), *camera).second) {
      return source.Wrong("cameras with different ids");
    }
  }
}

Result<void> ReadImages(ColmapSource& source, ColmapPoses& poses) {
  while (true) {
    WAYMARK_TRY_ASSIGN(const bool has_more, source.Next());
    if (!has_more) break;
    WAYMARK_TRY_ASSIGN([[maybe_unused]] const std::int64_t id, source.Integer("an image's id"));
    WAYMARK_TRY_ASSIGN(const Rigid3 pose, ReadPose(source));
    WAYMARK_TRY_ASSIGN(const std::int64_t camera, source.Integer("a camera's id"));
    if (camera < 0 || camera > UINT32_MAX ||
        !poses.cameras.contains(static_cast<std::uint32_t>(camera))) {
      return source.Wrong("the id of one of its cameras");
    }
    WAYMARK_TRY_ASSIGN(std::string name, source.Name());
    if (!IsImageName(name)) return source.Wrong("a relative path as the image's name");
    poses.images.push_back({std::move(name), static_cast<std::uint32_t>(camera), pose});
    WAYMARK_TRY(source.SkipPixels());
  }
  std::ranges::sort(poses.images, {}, &ColmapPoses::Image::name);
  const auto twin = std::ranges::adjacent_find(poses.images, {}, &ColmapPoses::Image::name);
  if (twin == poses.images.end()) return {};
  return source.Wrong("images with different names, not two of " + Quoted(twin->name));
}

}  // namespace

Result<ColmapPoses> LoadColmapPoses(const std::filesystem::path& folder) {
  ColmapPoses poses;
  WAYMARK_TRY_ASSIGN(const auto cameras, OpenColmapTable(folder, ColmapTable::kCameras));
  WAYMARK_TRY(ReadCameras(*cameras, poses));
  WAYMARK_TRY_ASSIGN(const auto images, OpenColmapTable(folder, ColmapTable::kImages));
  WAYMARK_TRY(ReadImages(*images, poses));
  if (!poses.images.empty()) return poses;
  return MakeError(ErrorCode::kCorrupt, "{}: expected a model with images, found none",
                   folder.string());
}

}  // namespace waymark::mapping::internal
