// SPDX-License-Identifier: Apache-2.0
#include "session/device/pose_tracker.h"

#include <algorithm>

namespace waymark::session {
namespace {

constexpr std::chrono::milliseconds kVelocityWindow{200};

}  // namespace

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
  const auto elapsed = vo_from_device_ ? time - time_ : std::chrono::nanoseconds::zero();
  vo_from_device_ = vo_from_device;
  time_ = time;
  if (!steps_.empty() && time <= steps_.back().time) steps_.clear();
  steps_.push_back({time, vo_from_device.translation()});
  while (time - steps_.front().time > kVelocityWindow) steps_.pop_front();
  Correct(std::max(elapsed, std::chrono::nanoseconds::zero()));
}

// It is the device's pose that is moved at a bounded rate: a turn about the odometry's origin would
// sweep a device far from it across the street.
void PoseTracker::Correct(std::chrono::duration<double> elapsed) {
  if (!current_.map_from_vo || !vo_from_device_) return;
  if (!shown_map_from_vo_) shown_map_from_vo_ = current_.map_from_vo;
  const Rigid3 shown = (*shown_map_from_vo_ * *vo_from_device_).rigid();
  const Rigid3 wanted = (*current_.map_from_vo * *vo_from_device_).rigid();
  const double offset_m = (wanted.translation() - shown.translation()).norm();
  const double turn_rad = AngleBetween(wanted.rotation(), shown.rotation()).radians();
  const double step_m = correction_.max_speed_mps * elapsed.count();
  const double step_rad = correction_.max_turn_per_s.radians() * elapsed.count();
  const bool is_at_once = !was_fixed_ || offset_m > correction_.max_offset_m;
  was_fixed_ = was_fixed_ || current_.state == localiser::AlignmentState::kFixed;
  if (is_at_once || (offset_m <= step_m && turn_rad <= step_rad)) {
    shown_map_from_vo_ = current_.map_from_vo;
    return;
  }
  const double fraction = std::min(offset_m > step_m ? step_m / offset_m : 1,
                                   turn_rad > step_rad ? step_rad / turn_rad : 1);
  shown_map_from_vo_ =
      Transform<Map, Device>(Interpolate(shown, wanted, fraction)) * vo_from_device_->Inverse();
}

void PoseTracker::AddFix(const SentFrame& frame, const localiser::LocalisedPose& pose,
                         FixSource source) {
  fix_source_ = source;
  const Transform<Camera, Device> camera_from_device = frame.device_from_camera.Inverse();
  const Eigen::Vector3d lever_in_map =
      pose.map_from_camera.rotation() * camera_from_device.translation();
  alignment_.AddFix({.time = frame.time,
                     .vo_from_device = frame.vo_from_device,
                     .map_from_device = pose.map_from_camera * camera_from_device,
                     .covariance = CarryCovariance(pose.covariance, lever_in_map),
                     .submap = pose.submap,
                     .submap_from_camera = pose.submap_from_camera,
                     .camera_from_device = camera_from_device});
  Refresh(std::max(frame.time, time_));
}

void PoseTracker::Reset() {
  alignment_.ResetOdometry();
  current_ = {};
  shown_map_from_vo_.reset();
  was_fixed_ = false;
}

std::optional<Transform<Map, Map>> PoseTracker::CarryTo(const Placements& placements) {
  const std::optional<Transform<Map, Map>> motion = alignment_.CarryTo(placements);
  if (!motion) {
    Reset();
    return std::nullopt;
  }
  if (shown_map_from_vo_) shown_map_from_vo_ = *motion * *shown_map_from_vo_;
  Refresh(time_);
  return motion;
}

void PoseTracker::ShiftTime(std::chrono::nanoseconds by) {
  alignment_.ShiftTime(by);
  for (Step& step : steps_) step.time += by;
  time_ += by;
}

void PoseTracker::Refresh(DeviceTime now) { current_ = alignment_.Estimate(now); }

DevicePose PoseTracker::Pose(std::uint64_t epoch) const {
  DevicePose pose{.state = current_.state,
                  .map_from_device = std::nullopt,
                  .covariance = current_.covariance,
                  .epoch = epoch,
                  .time = time_,
                  .fix_source = fix_source_};
  if (!current_.map_from_vo || !vo_from_device_) return pose;
  const Transform<Map, Vo>& map_from_vo = *current_.map_from_vo;
  const Transform<Map, Device> wanted = map_from_vo * *vo_from_device_;
  pose.map_from_device = shown_map_from_vo_.value_or(map_from_vo) * *vo_from_device_;
  const Eigen::Matrix<double, 6, 1> to_come =
      Difference(pose.map_from_device->rigid(), wanted.rigid());
  pose.covariance = CarryCovariance(current_.covariance,
                                    map_from_vo.rotation() * vo_from_device_->translation()) +
                    to_come * to_come.transpose();
  return pose;
}

Eigen::Vector3d PoseTracker::VelocityInMap() const {
  if (!current_.map_from_vo || steps_.size() < 2) return Eigen::Vector3d::Zero();
  const Step& from = steps_.front();
  const Step& to = steps_.back();
  return current_.map_from_vo->rotation() * (to.position_in_vo - from.position_in_vo) /
         Seconds(to.time - from.time);
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
