// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "session/device/device_session.h"
#include "session/state/messages.h"

namespace waymark::session {

/// What was known about an image when it was sent.
struct SentFrame {
  RequestNumber request{};
  DeviceTime time;
  Transform<Device, Camera> device_from_camera;
  Transform<Vo, Device> vo_from_device;
};

/// Keeps a device's odometry joined to the map. Pure; thread-compatible.
class PoseTracker {
 public:
  PoseTracker(const localiser::AlignmentOptions& alignment, const CorrectionOptions& correction)
      : alignment_(alignment), correction_(correction) {}

  /// Also moves the shown pose on towards the estimate.
  void PushOdometry(const Transform<Vo, Device>& vo_from_device, DeviceTime time);
  /// Takes the answer to an image as one more fix.
  void AddFix(const SentFrame& frame, const localiser::LocalisedPose& pose,
              FixSource source = FixSource::kServer);
  /// Forgets all fixes: the odometry or the map has another frame now.
  void Reset();
  /// Another release is live: fixes and the shown pose go where their submaps do, so that what is
  /// shown stays where it is for those who look. How it moved; nothing, and reset, where no fix is
  /// in a submap told.
  std::optional<Transform<Map, Map>> CarryTo(const Placements& placements);
  /// The clock that stamps odometry and frames was set forward by so much.
  void ShiftTime(std::chrono::nanoseconds by);
  /// Lets the alignment age; about a millisecond, so not for every frame.
  void Refresh(DeviceTime now);

  DevicePose Pose(std::uint64_t epoch) const;
  /// How fast the device moves by its odometry, over the last fifth of a second, in m/s; zero
  /// before two positions are known.
  Eigen::Vector3d VelocityInMap() const;
  /// The submaps of the fixes, newest first, at most as many as an anchor takes.
  std::vector<SubmapId> SeenIn() const;

 private:
  void Correct(std::chrono::duration<double> elapsed);

  localiser::OdometryAlignment alignment_;
  CorrectionOptions correction_;
  localiser::Alignment current_;
  std::optional<Transform<Map, Vo>> shown_map_from_vo_;
  FixSource fix_source_ = FixSource::kServer;
  bool was_fixed_ = false;  ///< enough fixes agreed once, since the last reset
  std::optional<Transform<Vo, Device>> vo_from_device_;
  DeviceTime time_;
  struct Step {
    DeviceTime time;
    Eigen::Vector3d position_in_vo;
  };
  std::deque<Step> steps_;  // of the last fifth of a second, oldest first
};

/// The covariance of b_from_c = b_from_a * a_from_c when only b_from_a is uncertain; both of
/// Perturb's delta in b. `lever_in_b` is b's rotation times the translation of a_from_c.
Eigen::Matrix<double, 6, 6> CarryCovariance(const Eigen::Matrix<double, 6, 6>& covariance,
                                            const Eigen::Vector3d& lever_in_b);

}  // namespace waymark::session
