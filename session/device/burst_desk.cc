// SPDX-License-Identifier: Apache-2.0
#include "session/device/internal/burst_desk.h"

#include <utility>

namespace waymark::session::internal {
namespace {

// Odometry that is good to 2 %, as the localiser takes it, is off by 0.3 m then.
constexpr double kMaxWay_m = 15;
constexpr std::chrono::seconds kMaxAge{20};

// Beyond these nobody moves, who carries a phone: odometry has leapt into another frame.
constexpr double kMaxSpeed_mps = 15;
constexpr double kLeap_m = 0.5;
constexpr Angle kMaxTurnPerS = Angle::Degrees(720);
constexpr Angle kLeapAngle = Angle::Degrees(20);
constexpr std::chrono::seconds kMaxPause{2};  // a call, another app before this one

// Two images nearer to each other than this show the same: who stands still sees nothing new.
constexpr double kSamePlace_m = 0.1;
constexpr Angle kSameAngle = Angle::Degrees(3);

constexpr double kStep_m = 0.1;  // smaller ones are noise, and no way

double Distance_m(const Rigid3& a, const Rigid3& b) {
  return (a.translation() - b.translation()).norm();
}

bool ShowTheSame(const Transform<Vo, Camera>& a, const Transform<Vo, Camera>& b) {
  return Distance_m(a.rigid(), b.rigid()) < kSamePlace_m &&
         AngleBetween(a.rotation(), b.rotation()) < kSameAngle;
}

// What the wire would refuse.
bool CanBeTold(const Rigid3& pose) {
  return pose.rotation().coeffs().allFinite() &&
         (pose.translation().array().abs() <= kMaxCoordinate_m).all();
}

bool WasNotFound(LocaliseStatus status) {
  return status == LocaliseStatus::kTooFewFeatures || status == LocaliseStatus::kTooFewMatches ||
         status == LocaliseStatus::kNoConsistentPose;
}

}  // namespace

bool BurstDesk::IsSteady(const Transform<Vo, Device>& vo_from_device, DeviceTime time) const {
  const auto elapsed = time - odometry_->time;
  const double elapsed_s = Seconds(elapsed);
  const Rigid3& before = odometry_->vo_from_device.rigid();
  const bool is_near = Distance_m(before, vo_from_device.rigid()) <=
                       kLeap_m + kMaxSpeed_mps * elapsed_s;  // not with numbers that are none
  const Angle turn = AngleBetween(before.rotation(), vo_from_device.rotation());
  return elapsed <= kMaxPause && is_near && turn <= kLeapAngle + elapsed_s * kMaxTurnPerS;
}

void BurstDesk::Observe(const Transform<Vo, Device>& vo_from_device, DeviceTime time) {
  if (max_images_ < 2) return;
  const bool is_late = odometry_ && time < odometry_->time && odometry_->time - time < kMaxPause;
  if (is_late) return;  // of a frame that was handed over after newer odometry
  const Eigen::Vector3d& position_in_vo = vo_from_device.translation();
  if (!odometry_ || time < odometry_->time || !IsSteady(vo_from_device, time)) {
    Forget();
    odometry_ = Odometry{vo_from_device, time, time, position_in_vo};
    return;
  }
  odometry_->vo_from_device = vo_from_device;
  odometry_->time = time;
  const double step_m = (position_in_vo - odometry_->counted_in_vo).norm();
  if (step_m < kStep_m) return;
  odometry_->way_m += step_m;
  odometry_->counted_in_vo = position_in_vo;
}

void BurstDesk::Ask(const DeviceFrame& frame, LocaliseQuery& query) {
  under_way_.reset();
  const Transform<Vo, Camera> vo_from_camera = frame.vo_from_device * frame.device_from_camera;
  const bool has_odometry = odometry_ && frame.time >= odometry_->begin;
  if (max_images_ < 2 || !has_odometry || !CanBeTold(vo_from_camera.rigid())) return;
  DropFarOnes(frame.time);
  query.vo_from_camera = vo_from_camera;
  for (const Image& image : unfound_) {
    if (!ShowTheSame(image.asked.vo_from_camera, vo_from_camera)) {
      query.earlier.push_back(image.asked);
    }
  }
  under_way_ = Image{{query.request, vo_from_camera}, frame.time, odometry_->way_m};
}

void BurstDesk::DropFarOnes(DeviceTime now) {
  std::erase_if(unfound_, [&](const Image& image) {
    return now - image.time > kMaxAge || odometry_->way_m - image.way_m > kMaxWay_m;
  });
}

void BurstDesk::OnAnswer(RequestNumber request, LocaliseStatus status) {
  if (!under_way_ || under_way_->asked.request != request) return;
  if (status == LocaliseStatus::kLocalised) unfound_.clear();
  if (WasNotFound(status)) {
    std::erase_if(unfound_, [&](const Image& image) {
      return ShowTheSame(image.asked.vo_from_camera, under_way_->asked.vo_from_camera);
    });
    unfound_.push_back(*under_way_);
    if (unfound_.size() >= static_cast<std::size_t>(max_images_)) unfound_.pop_front();
  }
  under_way_.reset();
}

void BurstDesk::Forget() {
  unfound_.clear();
  under_way_.reset();
}

void BurstDesk::ShiftTime(std::chrono::nanoseconds by) {
  for (Image& image : unfound_) image.time += by;
  if (under_way_) under_way_->time += by;
  if (!odometry_) return;
  odometry_->time += by;
  odometry_->begin += by;
}

}  // namespace waymark::session::internal
