// SPDX-License-Identifier: Apache-2.0
#include "session/device/remote_track.h"

#include <algorithm>
#include <cmath>

#include "mapping/base/quantile.h"

namespace waymark::session {
namespace {

using Duration = std::chrono::duration<double>;

constexpr std::size_t kMaxHeard = 64;
constexpr std::size_t kLatenessWindow = 90;  // three seconds of a near one
constexpr double kLateShare = 0.95;
constexpr double kGrowsBy = 0.25;  // seconds of delay per second
constexpr double kShrinksBy = 0.05;
constexpr double kMotionLasts_s = 2;  // extrapolated motion fades so fast
constexpr double kTurnLasts_s = 0.2;
constexpr Duration kTurnWindow{0.1};
constexpr Duration kImplausible{1};
constexpr double kVelocitySigma_mps = 0.15;
constexpr double kAcceleration_mps2 = 2;
constexpr double kWalking_mps = 1.5;
constexpr double kTurning_radps = 0.7;  // one sigma, unforeseen: heads turn fast
constexpr double kMostTurned_rad = 0.7;
constexpr double kJump_m = 3;  // more is no motion: the pose was wrong before

/// How far something gets in a time that it slows down over.
double Coasted_s(double elapsed_s, double lasts_s) {
  return lasts_s * (1 - std::exp(-elapsed_s / lasts_s));
}

/// Through both positions with both velocities.
Eigen::Vector3d Hermite(const LivePose& a, const LivePose& b, double span_s, double fraction) {
  const double f = fraction, f2 = f * f, f3 = f2 * f;
  return (2 * f3 - 3 * f2 + 1) * a.map_from_device.translation() +
         (f3 - 2 * f2 + f) * span_s * a.velocity_in_map +
         (3 * f2 - 2 * f3) * b.map_from_device.translation() +
         (f3 - f2) * span_s * b.velocity_in_map;
}

double SigmaAfter(double sigma_m, double elapsed_s) {
  const double unseen_m =
      kVelocitySigma_mps * elapsed_s +
      std::min(kAcceleration_mps2 / 2 * elapsed_s * elapsed_s, kWalking_mps * elapsed_s);
  return std::hypot(sigma_m, unseen_m);
}

double RotationSigmaAfter(double sigma_rad, double elapsed_s) {
  return std::hypot(sigma_rad, std::min(kTurning_radps * elapsed_s, kMostTurned_rad));
}

}  // namespace

void RemoteTrack::Hear(const LivePose& pose, ServerTime arrived) {
  if (!heard_.empty() && heard_.back().epoch != pose.epoch) {
    if (pose.epoch < heard_.back().epoch && pose.time < heard_.back().time) return;
    heard_.clear();
    offset_.setZero();
  }
  const auto place =
      std::upper_bound(heard_.begin(), heard_.end(), pose,
                       [](const LivePose& a, const LivePose& b) { return a.time < b.time; });
  if (place != heard_.begin() && std::prev(place)->time == pose.time) return;
  const std::optional<Shown> before = At(arrived);
  heard_.insert(place, pose);
  if (heard_.size() > kMaxHeard) heard_.pop_front();
  AdaptTo(arrived - pose.time, arrived);
  arrived_ = arrived;
  offset_.setZero();
  if (!before || arrived < pose.time - kImplausible) return;
  offset_ = Difference(At(arrived)->map_from_device.rigid(), before->map_from_device.rigid());
  if (offset_.head<3>().norm() > kJump_m) offset_.setZero();
}

void RemoteTrack::AdaptTo(Duration lateness, ServerTime arrived) {
  lateness_s_.push_back(lateness.count());
  if (lateness_s_.size() > kLatenessWindow) lateness_s_.pop_front();
  const Duration late(
      Quantile(std::vector<double>(lateness_s_.begin(), lateness_s_.end()), kLateShare));
  const Duration wanted = std::clamp(late - options_.horizon, Duration(0), options_.max_delay);
  const double elapsed_s = arrived_ ? std::max(0.0, Seconds(arrived - *arrived_)) : 0;
  delay_ = std::clamp(wanted, delay_ - Duration(kShrinksBy * elapsed_s),
                      delay_ + Duration(kGrowsBy * elapsed_s));
}

std::optional<RemoteTrack::Shown> RemoteTrack::At(ServerTime now) const {
  if (heard_.empty()) return std::nullopt;
  // Before the session's clock is known, the newest is as good as any.
  const bool is_plausible = now > heard_.back().time - kImplausible;
  const ServerTime wanted = is_plausible
                                ? now - std::chrono::duration_cast<std::chrono::nanoseconds>(delay_)
                                : heard_.back().time;
  Shown shown = Predict(wanted);
  shown.sigma_m = std::hypot(shown.sigma_m, heard_.back().velocity_in_map.norm() * delay_.count());
  shown.rotation_sigma_rad = RotationSigmaAfter(shown.rotation_sigma_rad, delay_.count());
  if (arrived_ && now > *arrived_ - kImplausible) {
    const double since_s = std::max(0.0, Seconds(now - *arrived_));
    Eigen::Matrix<double, 6, 1> left = offset_;
    left.head<3>() *= std::exp(-since_s / options_.settling.count());
    left.tail<3>() *= std::exp(-since_s / options_.turn_settling.count());
    shown.map_from_device = Transform<Map, Device>(Perturb(shown.map_from_device.rigid(), left));
  }
  return shown;
}

RemoteTrack::Shown RemoteTrack::Predict(ServerTime instant) const {
  if (instant >= heard_.back().time) return Extrapolate(instant);
  const auto after =
      std::upper_bound(heard_.begin(), heard_.end(), instant,
                       [](ServerTime wanted, const LivePose& pose) { return wanted < pose.time; });
  if (after == heard_.begin()) {
    return {heard_.front().map_from_device, heard_.front().sigma_m,
            heard_.front().rotation_sigma_rad};
  }
  const LivePose& a = *std::prev(after);
  const LivePose& b = *after;
  const double span_s = Seconds(b.time - a.time);
  const double fraction = Seconds(instant - a.time) / span_s;
  const Rigid3 turned = Interpolate(a.map_from_device.rigid(), b.map_from_device.rigid(), fraction);
  const double unseen_s = span_s * std::min(fraction, 1 - fraction);
  return {{turned.rotation(), Hermite(a, b, span_s, fraction)},
          SigmaAfter(std::max(a.sigma_m, b.sigma_m), unseen_s),
          RotationSigmaAfter(std::max(a.rotation_sigma_rad, b.rotation_sigma_rad), unseen_s)};
}

RemoteTrack::Shown RemoteTrack::Extrapolate(ServerTime instant) const {
  const LivePose& newest = heard_.back();
  const double elapsed_s = Seconds(instant - newest.time);
  const Eigen::Vector3d position = newest.map_from_device.translation() +
                                   newest.velocity_in_map * Coasted_s(elapsed_s, kMotionLasts_s);
  Eigen::Quaterniond rotation = newest.map_from_device.rotation();
  const auto earlier = std::find_if(heard_.rbegin(), heard_.rend(), [&](const LivePose& pose) {
    return newest.time - pose.time >= kTurnWindow;
  });
  if (earlier != heard_.rend()) {
    const double span_s = Seconds(newest.time - earlier->time);
    // About the vertical alone: other turns sway back with the steps before they are heard of.
    const double turned_rad =
        VectorFromRotation(rotation * earlier->map_from_device.rotation().conjugate()).z();
    const double ahead_rad = turned_rad / span_s * Coasted_s(elapsed_s, kTurnLasts_s);
    rotation = Eigen::AngleAxisd(ahead_rad, Eigen::Vector3d::UnitZ()) * rotation;
  }
  return {{rotation, position},
          SigmaAfter(newest.sigma_m, elapsed_s),
          RotationSigmaAfter(newest.rotation_sigma_rad, elapsed_s)};
}

}  // namespace waymark::session
