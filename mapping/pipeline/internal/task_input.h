// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mapping/pipeline/internal/plan.h"
#include "mapping/pipeline/internal/run.h"
#include "mapping/store/map_directory.h"

namespace waymark::mapping {

/// Where an image stands in an unbroken run of gyroscope data of its camera.
struct GyroscopeChain {
  std::uint32_t chain = 0;  ///< unbroken runs of one experience have different numbers
  Eigen::Quaterniond now_from_start = Eigen::Quaterniond::Identity();
};

/// A task with everything it names, in memory. Vectors of images have the task's order.
struct TaskInput {
  SubmapTask task;
  bool uses_gnss = true;  ///< false: the map is local, so fixes mean nothing in it
  std::vector<IndexedImage> images = {};
  std::vector<GyroscopeChain> chains = {};
  std::vector<ImageFeatures> features = {};
  std::vector<std::string> sequences = {};  ///< camera of an experience
  std::vector<SfmCamera> cameras = {};
  std::vector<std::uint32_t> camera_of_image = {};
  std::vector<std::uint32_t> group_of_image = {};  ///< experience
  /// By image; rigs of different experiences differ.
  std::vector<std::optional<CameraMount>> mounts = {};
};

/// Errors: NotFound (task, experience, image or features are not in the map), Conflict (an
/// experience changed since the plan), Corrupt.
Result<TaskInput> LoadTaskInput(const MapDirectory& map, const std::filesystem::path& folder,
                                const std::string& task, const Parallelism& parallelism);

/// Rotations between consecutive registered images of each sequence, also across images of the
/// experience that were not registered or are not in the task.
std::vector<MeasuredRotation> ComposeRotations(const TaskInput& input,
                                               const Reconstruction& reconstruction);

}  // namespace waymark::mapping
