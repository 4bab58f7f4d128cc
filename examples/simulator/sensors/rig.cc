// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/sensors/rig.h"

#include <array>
#include <cmath>

namespace waymark::simulator {

Result<void> CameraOptions::Validate() const {
  if (width_px < 32 || width_px > 4096 || height_px < 32 || height_px > 4096) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "camera: expected 32 to 4096 pixels a side, found {} x {}", width_px,
                     height_px);
  }
  const double degrees = field_of_view.degrees();
  if (!(degrees >= 20 && degrees <= 120)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "camera: field of view must lie in [20, 120] degrees, found {}", degrees);
  }
  return {};
}

Result<CameraModel> MakeCamera(const CameraOptions& options) {
  WAYMARK_TRY(options.Validate());
  const double focal = options.width_px / 2.0 / std::tan(options.field_of_view.radians() / 2);
  const double x = options.width_px / 2.0;
  const double y = options.height_px / 2.0;
  if (options.lens == Lens::kPinhole) {
    return CameraModel::Create(CameraKind::kSimplePinhole, options.width_px, options.height_px,
                               std::array{focal, x, y});
  }
  return CameraModel::Create(CameraKind::kOpenCv, options.width_px, options.height_px,
                             std::array{focal, focal, x + 2.5, y - 1.5, -0.12, 0.03, 4e-4, -3e-4});
}

Eigen::Quaterniond BodyFromCameraRotation(Angle yaw, Angle pitch) {
  Eigen::Matrix3d forward_looking;  // columns: the camera's right, down, forward in body axes
  forward_looking << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Eigen::AngleAxisd(yaw.radians(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(-pitch.radians(), Eigen::Vector3d::UnitY()) *
         Eigen::Quaterniond(forward_looking);
}

Result<std::vector<MountedCamera>> MakeCarRig(int count, const CameraOptions& options) {
  struct Mount {
    const char* id;
    Angle yaw;
    Eigen::Vector3d place;
    double delay_s;
  };
  const std::array<Mount, 4> mounts{{{"front", Angle::Degrees(0), {0.4, 0, 0.05}, 0},
                                     {"left", Angle::Degrees(90), {0.1, 0.5, 0}, 0.011},
                                     {"right", Angle::Degrees(-90), {0.1, -0.5, 0}, 0.023},
                                     {"rear", Angle::Degrees(180), {-0.6, 0, 0.05}, 0.036}}};
  if (count < 1 || count > static_cast<int>(mounts.size())) {
    return MakeError(ErrorCode::kInvalidArgument, "car: expected 1 to {} cameras, found {}",
                     mounts.size(), count);
  }
  WAYMARK_TRY_ASSIGN(const CameraModel model, MakeCamera(options));
  std::vector<MountedCamera> cameras;
  for (const Mount& mount : std::span(mounts).first(static_cast<std::size_t>(count))) {
    cameras.push_back({mount.id, model,
                       Rigid3(BodyFromCameraRotation(mount.yaw, Angle::Degrees(6)), mount.place),
                       mount.delay_s});
  }
  return cameras;
}

Result<std::vector<MountedCamera>> MakePhoneRig(const CameraOptions& options) {
  WAYMARK_TRY_ASSIGN(const CameraModel model, MakeCamera(options));
  return std::vector<MountedCamera>{
      {"camera", model,
       Rigid3(BodyFromCameraRotation(Angle::Degrees(0), Angle::Degrees(0)), {0.01, 0.02, 0.03}),
       0}};
}

}  // namespace waymark::simulator
