// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "localiser/localiser.h"
#include "mapping/base/result.h"
#include "mapping/geometry/camera_model.h"

namespace waymark::localiser::internal {

/// Poses vo_from_camera by the names of images, or by their timestamps.
using OdometryPoses = std::map<std::string, Rigid3>;

/// Lines of "name tx ty tz qx qy qz qw", as TUM's trajectories; empty lines and those that start
/// with # are skipped. Errors: Corrupt with `file` and line.
Result<OdometryPoses> ParseOdometry(std::string_view text, std::string_view file);

/// Which images make a burst, and how odometry lies.
struct BurstQuery {
  std::span<const std::string> images;  ///< paths, oldest first
  std::filesystem::path odometry;       ///< names each image as a file, with its ending or without
  std::optional<CameraModel> camera;    ///< of all; absent: guessed from their sizes
  Eigen::Vector3d up_in_odometry = Eigen::Vector3d::UnitZ();
};

/// Reads images and odometry, which is turned until its z is up.
/// Errors: NotFound (a file, an image that odometry does not name), Corrupt, InvalidArgument.
Result<BurstRequest> LoadBurst(const BurstQuery& query);

}  // namespace waymark::localiser::internal
