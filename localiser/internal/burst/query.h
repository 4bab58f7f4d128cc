// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "localiser/localiser.h"
#include "mapping/base/result.h"
#include "mapping/geometry/camera_model.h"

namespace waymark::localiser::internal {

/// Which images make a burst, and how odometry lies.
struct BurstQuery {
  std::span<const std::string> images;  ///< paths, oldest first
  std::filesystem::path odometry;       ///< TUM's; names images with their ending or without
  std::optional<CameraModel> camera;    ///< of all; absent: guessed from their sizes
  Eigen::Vector3d up_in_odometry = Eigen::Vector3d::UnitZ();
};

/// Reads images and odometry, which is turned until its z is up.
/// Errors: NotFound (a file, an image that odometry does not name), Corrupt, InvalidArgument.
Result<BurstRequest> LoadBurst(const BurstQuery& query);

}  // namespace waymark::localiser::internal
