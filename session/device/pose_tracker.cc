// SPDX-License-Identifier: Apache-2.0
#include "session/device/pose_tracker.h"

#include <algorithm>

namespace waymark::session {

Eigen::Matrix<double, 6, 6> CarryCovariance(const Eigen::Matrix<double, 6, 6>& covariance,
                                            const Eigen::Vector3d& lever_in_b) {
  // d(t + R l) = dt + dr x (R l)
  Eigen::Matrix<double, 6, 6> jacobian = Eigen::Matrix<double, 6, 6>::Identity();
  jacobian(0, 4) = lever_in_b.z();
  jacobian(0, 5) = -lever_in_b.y();
  jacobian(1, 3) = -lever_in_b.z();
  jacobian(1, 5) = lever_in_b.x();
  jacobian(2, 3) = lever_in_b.y();
  jacobian(2, 4) = -lever_in_b.x();
  return jacobian * covariance * jacobian.transpose();
}

void PoseTracker::PushOdometry(const Transform<Vo, Device>& vo_from_device, DeviceTime time) {
  vo_from_device_ = vo_from_device;
  time_ = time;
}

void PoseTracker::AddFix(const SentFrame& frame, const localiser::LocalisedPose& pose) {
  const Transform<Camera, Device> camera_from_device = frame.device_from_camera.Inverse();
  const Eigen::Vector3d lever_in_map =
      pose.map_from_camera.rotation() * camera_from_device.translation();
  alignment_.AddFix({.time = frame.time,
                     .vo_from_device = frame.vo_from_device,
                     .map_from_device = pose.map_from_camera * camera_from_device,
                     .covariance = CarryCovariance(pose.covariance, lever_in_map),
                     .submap = pose.submap,
                     .submap_from_device = pose.submap_from_camera * camera_from_device});
  Refresh(std::max(frame.time, time_));
}

void PoseTracker::Reset() {
  alignment_.ResetOdometry();
  current_ = {};
}

void PoseTracker::Refresh(DeviceTime now) { current_ = alignment_.Estimate(now); }

DevicePose PoseTracker::Pose(std::uint64_t epoch) const {
  DevicePose pose{.state = current_.state,
                  .map_from_device = std::nullopt,
                  .covariance = current_.covariance,
                  .epoch = epoch,
                  .time = time_};
  if (!current_.map_from_vo || !vo_from_device_) return pose;
  const Transform<Map, Vo>& map_from_vo = *current_.map_from_vo;
  pose.map_from_device = map_from_vo * *vo_from_device_;
  pose.covariance =
      CarryCovariance(current_.covariance, map_from_vo.rotation() * vo_from_device_->translation());
  return pose;
}

std::vector<SubmapId> PoseTracker::SeenIn() const {
  std::vector<SubmapId> submaps;
  const auto& fixes = alignment_.fixes();
  for (auto fix = fixes.rbegin(); fix != fixes.rend() && submaps.size() < kMaxAttachments; ++fix) {
    if (std::find(submaps.begin(), submaps.end(), fix->submap) == submaps.end()) {
      submaps.push_back(fix->submap);
    }
  }
  return submaps;
}

}  // namespace waymark::session
