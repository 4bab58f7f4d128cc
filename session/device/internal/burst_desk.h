// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include "session/device/device_session.h"
#include "session/state/messages.h"

namespace waymark::session::internal {

/// Which keyframes are asked once more, together with the next: those that were not found, from
/// where odometry has not drifted far since. What was found is in a fix already, and its evidence
/// counts once. Pure; thread-compatible.
class BurstDesk {
 public:
  explicit BurstDesk(int max_images) : max_images_(max_images) {}

  /// Odometry at that instant. After a leap, or a long silence, its frame may be another, and
  /// earlier images mean nothing any more.
  void Observe(const Transform<Vo, Device>& vo_from_device, DeviceTime time);
  /// The frame goes to the server now: adds to its query where odometry saw it, and the images
  /// before it.
  void Ask(const DeviceFrame& frame, LocaliseQuery& query);
  void OnAnswer(RequestNumber request, LocaliseStatus status);
  /// The server has no earlier images of this device.
  void Forget();
  /// The clock that stamps frames and odometry was set forward by so much.
  void ShiftTime(std::chrono::nanoseconds by);

 private:
  struct Image {
    EarlierImage asked;
    DeviceTime time;
    double way_m;  ///< that odometry had come since its first instant
  };
  struct Odometry {
    Transform<Vo, Device> vo_from_device;
    DeviceTime time;
    DeviceTime begin;               ///< of its frame, as far as is known
    Eigen::Vector3d counted_in_vo;  ///< up to where the way is counted
    double way_m = 0;
  };

  bool IsSteady(const Transform<Vo, Device>& vo_from_device, DeviceTime time) const;
  void DropFarOnes(DeviceTime now);

  int max_images_;
  std::optional<Odometry> odometry_;
  std::optional<Image> under_way_;
  std::deque<Image> unfound_;  // oldest first, at most max_images_ - 1
};

}  // namespace waymark::session::internal
