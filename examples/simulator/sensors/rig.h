// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mapping/base/result.h"
#include "mapping/geometry/angle.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::simulator {

/// What is in front of the sensor.
enum class Lens {
  kPinhole,    ///< SIMPLE_PINHOLE
  kDistorted,  ///< OPENCV with the barrel distortion of a wide lens
};

struct CameraOptions {
  int width_px = 640;                        ///< [32, 4096]
  int height_px = 480;                       ///< [32, 4096]
  Angle field_of_view = Angle::Degrees(65);  ///< horizontal, [20, 120] degrees
  Lens lens = Lens::kPinhole;

  Result<void> Validate() const;
};

/// A camera fixed to a body (x forward, y left, z up).
struct MountedCamera {
  std::string id;
  CameraModel model;
  Rigid3 body_from_camera;
  double delay_s = 0;  ///< against the first camera: cameras are not synchronised
};

/// Errors: InvalidArgument for options out of range.
Result<CameraModel> MakeCamera(const CameraOptions& options);

/// The turn of a camera that looks along a yaw (left positive) and pitch (up positive) of its body.
Eigen::Quaterniond BodyFromCameraRotation(Angle yaw, Angle pitch);

/// `count` cameras in [1, 4] on a car's roof: front, left, right, rear.
/// Errors: InvalidArgument for a count or options out of range.
Result<std::vector<MountedCamera>> MakeCarRig(int count, const CameraOptions& options);

/// The one camera of a phone, a little off the device's origin.
Result<std::vector<MountedCamera>> MakePhoneRig(const CameraOptions& options);

}  // namespace waymark::simulator
