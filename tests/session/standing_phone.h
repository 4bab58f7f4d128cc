// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>

#include "mapping/geometry/geodesy.h"
#include "session/device/device_session.h"

namespace waymark::session::support {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Waits until the condition holds; false when it does not within a generous time.
inline bool Eventually(const std::function<bool()>& condition, seconds patience = seconds(60)) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(milliseconds(5));
  }
  return true;
}

inline GeoPoint MapOrigin() {
  return {.latitude = Angle::Degrees(52.5),
          .longitude = Angle::Degrees(13.4),
          .ellipsoid_height_m = 80};
}

/// The camera looks along the device's x; both axes of the device are level when it is.
inline Transform<Device, Camera> DeviceFromCamera() {
  Eigen::Matrix3d rotation;
  rotation << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {Eigen::Quaterniond(rotation), {0.1, 0, 0.05}};
}

/// A phone that stands somewhere and faces east. Its odometry started 1 m north of the map's
/// origin.
class StandingPhone {
 public:
  StandingPhone(DeviceSession& session, const Eigen::Vector3d& position_in_map)
      : session_(session), position_in_map_(position_in_map) {}

  void MoveTo(const Eigen::Vector3d& position_in_map) { position_in_map_ = position_in_map; }

  Transform<Vo, Device> VoFromDevice() const {
    return {Eigen::Quaterniond::Identity(), position_in_map_ - Eigen::Vector3d(0, 1, 0)};
  }

  /// Phones stamp with clocks of their own.
  static DeviceTime Now() {
    return DeviceTime(std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::steady_clock::now().time_since_epoch() + std::chrono::hours(1234)));
  }

  /// Somebody sets its clock forward.
  void SetClock(std::chrono::nanoseconds forward) { set_ += forward; }
  DeviceTime OwnNow() const { return Now() + set_; }

  /// One moment of its life: odometry and a frame.
  void Live() {
    const DeviceTime now = OwnNow();
    session_.PushOdometry(VoFromDevice(), now);
    EXPECT_TRUE(session_.PushFrame(MakeFrame(now)).ok());
  }

  /// Lives until it is well localised.
  bool Localise() {
    return Eventually([this] {
      Live();
      return session_.Pose().state == localiser::AlignmentState::kFixed;
    });
  }

 private:
  DeviceFrame MakeFrame(DeviceTime time) const {
    constexpr int kWidth = 64, kHeight = 48;
    const std::array<double, 3> parameters{60, 32, 24};
    DeviceFrame frame{
        .width_px = kWidth,
        .height_px = kHeight,
        .pixels = std::vector<std::uint8_t>(kWidth * kHeight, 128),
        .camera = *CameraModel::Create(CameraKind::kSimplePinhole, kWidth, kHeight, parameters),
        .device_from_camera = DeviceFromCamera(),
        .vo_from_device = VoFromDevice(),
        .time = time};
    frame.gnss = TangentPlane(MapOrigin()).ToGeo(Point<Map>(position_in_map_));
    return frame;
  }

  DeviceSession& session_;
  Eigen::Vector3d position_in_map_;
  std::chrono::nanoseconds set_{0};
};

inline std::optional<OtherDevice> FindOther(const DeviceSession& session, const DeviceId& id) {
  for (const OtherDevice& other : session.Others()) {
    if (other.id == id) return other;
  }
  return std::nullopt;
}

inline bool Sees(const DeviceSession& session, const DeviceId& id) {
  const auto other = FindOther(session, id);
  return other && other->is_present;
}

inline std::optional<SharedAnchor> FindAnchor(const DeviceSession& session, const AnchorId& id) {
  for (const SharedAnchor& anchor : session.Anchors()) {
    if (anchor.id == id) return anchor;
  }
  return std::nullopt;
}

}  // namespace waymark::session::support
