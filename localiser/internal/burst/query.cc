// SPDX-License-Identifier: Apache-2.0
#include "localiser/internal/burst/query.h"

#include <utility>

#include "localiser/internal/query_images.h"
#include "mapping/base/file.h"
#include "mapping/io/tum_trajectory.h"

namespace waymark::localiser::internal {
namespace {

Result<Rigid3> FindPose(const mapping::NamedPoses& poses, const BurstQuery& query,
                        const std::filesystem::path& image) {
  for (const std::string& name :
       {image.string(), image.filename().string(), image.stem().string()}) {
    if (const auto found = poses.find(name); found != poses.end()) return found->second;
  }
  return MakeError(ErrorCode::kNotFound, "{}: expected a pose of {}, found {} others",
                   query.odometry.string(), image.filename().string(), poses.size());
}

Result<LocalisationRequest> LoadRequest(const std::filesystem::path& image,
                                        const std::optional<CameraModel>& stated) {
  WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(image));
  WAYMARK_TRY_ASSIGN(mapping::GrayImage pixels, mapping::DecodeGrayImage(bytes));
  auto camera = stated ? Result<CameraModel>(*stated) : GuessCamera(pixels);
  if (!camera) return camera.error();
  return LocalisationRequest{std::move(pixels), *camera, std::nullopt, std::nullopt};
}

}  // namespace

Result<BurstRequest> LoadBurst(const BurstQuery& query) {
  if (!query.up_in_odometry.allFinite() || !(query.up_in_odometry.norm() > 0)) {
    return MakeError(ErrorCode::kInvalidArgument, "odometry's up: expected a direction");
  }
  const Rigid3 level_from_odometry(
      Eigen::Quaterniond::FromTwoVectors(query.up_in_odometry, Eigen::Vector3d::UnitZ()),
      Eigen::Vector3d::Zero());
  WAYMARK_TRY_ASSIGN(const std::string text, LoadTextFile(query.odometry));
  WAYMARK_TRY_ASSIGN(const mapping::NamedPoses poses,
                     mapping::ParseTumTrajectory(text, query.odometry.string()));
  BurstRequest burst;
  for (const std::string& image : query.images) {
    WAYMARK_TRY_ASSIGN(const Rigid3 odometry_from_camera, FindPose(poses, query, image));
    WAYMARK_TRY_ASSIGN(auto request, LoadRequest(image, query.camera));
    burst.images.push_back(
        {std::move(request), Transform<Vo, Camera>(level_from_odometry * odometry_from_camera)});
  }
  return burst;
}

}  // namespace waymark::localiser::internal
