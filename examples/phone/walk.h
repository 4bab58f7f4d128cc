// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <variant>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/base/time.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/frames.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::phone {

/// Odometry at one instant of the recording.
struct OdometrySample {
  DeviceTime time;
  Transform<Vo, Device> vo_from_device;
};

/// A camera image of the recording, with the odometry interpolated to it.
struct WalkFrame {
  DeviceTime time;
  std::string name;
  std::filesystem::path path;
  Transform<Vo, Device> vo_from_device;
  std::optional<GeoPoint> gnss;  ///< the last one before the frame
  double gnss_sigma_m = 10;
};

/// What a phone recorded while its owner walked: nothing that a phone would not know.
struct Walk {
  CameraModel camera;
  Transform<Device, Camera> device_from_camera;
  std::vector<OdometrySample> odometry;  ///< by time
  std::vector<WalkFrame> frames;         ///< by time
};

/// Reads a walk from a kapture folder: one camera in a rig, odometry in trajectories.txt.
/// Errors: those of the reader; InvalidArgument when camera, rig or odometry is missing.
Result<Walk> LoadWalk(const std::filesystem::path& folder);

}  // namespace waymark::phone
