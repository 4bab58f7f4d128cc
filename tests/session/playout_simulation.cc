// SPDX-License-Identifier: Apache-2.0
#include "tests/session/playout_simulation.h"

namespace waymark::session::support {
namespace {

constexpr double kStep_s = 0.01;
constexpr double kDuration_s = 120;
constexpr double kFrame_s = 1 / 30.0;

ServerTime At(double time_s) {
  return ServerTime(std::chrono::hours(1) +
                    std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * time_s)));
}

void Note(const LivePose& truth, const RemoteTrack::Shown& told,
          std::optional<Eigen::Vector3d>& before, DisplayErrors& errors) {
  const Transform<Map, Device>& shown = told.map_from_device;
  const Eigen::Vector3d error = shown.translation() - truth.map_from_device.translation();
  errors.position_m.push_back(error.norm());
  errors.rotation_rad.push_back(
      AngleBetween(shown.rotation(), truth.map_from_device.rotation()).radians());
  if (before) errors.jump_m.push_back((error - *before).norm());
  before = error;
  errors.per_sigma.push_back(error.norm() / std::max(told.sigma_m, 1e-6));
  errors.rotation_per_sigma.push_back(errors.rotation_rad.back() /
                                      std::max(told.rotation_sigma_rad, 1e-6));
}

}  // namespace

Stroller::Stroller(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> chance(0, 1);
  double wanted_mps = 1.4, heading = 0, wanted_heading = 0, gaze = 0, wanted_gaze = 0, pitch = 0;
  double gaze_rate = 0;
  Eigen::Vector3d position(0, 0, 1.5), velocity = Eigen::Vector3d::Zero();
  for (double time_s = 0; time_s <= kDuration_s + 5; time_s += kStep_s) {
    if (chance(random) < 0.2 * kStep_s)
      wanted_mps = chance(random) < 0.3 ? 0 : 1.0 + chance(random);
    if (chance(random) < 0.25 * kStep_s) wanted_heading += 0.9 * normal(random);
    if (chance(random) < 0.5 * kStep_s) wanted_gaze = 0.6 * normal(random);
    heading += kStep_s / 0.4 * (wanted_heading - heading);
    const Eigen::Vector3d wanted =
        wanted_mps * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
    const Eigen::Vector3d push = (wanted - velocity) / 0.35;
    velocity += kStep_s * (push.norm() > 2.5 ? Eigen::Vector3d(2.5 * push.normalized()) : push);
    position += kStep_s * velocity;
    // The hand follows the gaze like a damped spring, and sways with the steps.
    gaze_rate += kStep_s * (40 * (wanted_gaze - gaze) - 9 * gaze_rate);
    gaze += kStep_s * gaze_rate;
    pitch = 0.03 * velocity.norm() * std::sin(2 * 3.14159 * 1.9 * time_s);
    const Eigen::Vector3d sway(0, 0, 0.02 * velocity.norm() * std::sin(2 * 3.14159 * 1.9 * time_s));
    LivePose pose{.epoch = 1,
                  .time = At(time_s),
                  .map_from_device = {},
                  .sigma_m = 0.02,
                  .rotation_sigma_rad = 0.004};
    pose.map_from_device = {
        Eigen::Quaterniond(Eigen::AngleAxisd(heading + gaze, Eigen::Vector3d::UnitZ()) *
                           Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY())),
        position + sway};
    pose.velocity_in_map = velocity;
    path_.push_back(pose);
  }
}

LivePose Stroller::PoseAt(double time_s) const {
  const double step = time_s / kStep_s;
  const auto at = std::min(static_cast<std::size_t>(step), path_.size() - 2);
  LivePose pose = path_[at];
  pose.time = At(time_s);
  pose.map_from_device = Transform<Map, Device>(Interpolate(path_[at].map_from_device.rigid(),
                                                            path_[at + 1].map_from_device.rigid(),
                                                            step - static_cast<double>(at)));
  return pose;
}

double Stroller::duration_s() const { return kDuration_s; }

PlayoutErrors SimulatePlayout(const NetworkProfile& profile, const PlayoutOptions& options,
                              std::uint64_t seed) {
  const Stroller stroller(seed);
  NetworkPath up(profile, 2 * seed + 1), down(profile, 2 * seed + 2);
  std::multimap<double, LivePose> at_server, at_phone;
  for (double time_s = 0; time_s < stroller.duration_s(); time_s += kFrame_s) {
    // Its velocity is over the last fifth of a second, as PoseTracker has it.
    LivePose pose = stroller.PoseAt(time_s);
    const double window_s = std::min(0.2, time_s);
    if (window_s > 0) {
      pose.velocity_in_map = (pose.map_from_device.translation() -
                              stroller.PoseAt(time_s - window_s).map_from_device.translation()) /
                             window_s;
    }
    if (const auto arrives_s = up.ArrivalOf(time_s)) at_server.emplace(*arrives_s, pose);
  }
  // The server tells at each tick the newest that it has not told yet.
  std::optional<LivePose> newest;
  auto next = at_server.begin();
  for (double tick_s = 0.007; tick_s < stroller.duration_s() + 1; tick_s += kFrame_s) {
    bool is_new = false;
    for (; next != at_server.end() && next->first <= tick_s; ++next) {
      if (newest && next->second.time <= newest->time) continue;
      newest = next->second;
      is_new = true;
    }
    if (!is_new) continue;
    if (const auto arrives_s = down.ArrivalOf(tick_s)) at_phone.emplace(*arrives_s, *newest);
  }
  PlayoutErrors errors;
  RemoteTrack track(options);
  std::optional<LivePose> latest;
  std::optional<Eigen::Vector3d> before_track, before_latest;
  auto arriving = at_phone.begin();
  for (double now_s = 5.013; now_s < stroller.duration_s(); now_s += kFrame_s) {
    for (; arriving != at_phone.end() && arriving->first <= now_s; ++arriving) {
      track.Hear(arriving->second, At(arriving->first));
      if (!latest || arriving->second.time > latest->time) latest = arriving->second;
    }
    const LivePose truth = stroller.PoseAt(now_s);
    const auto shown = track.At(At(now_s));
    if (!shown) continue;
    Note(truth, *shown, before_track, errors.track);
    Note(truth, {latest->map_from_device, latest->sigma_m, latest->rotation_sigma_rad},
         before_latest, errors.latest);
    errors.mean_delay_s += track.delay().count();
  }
  errors.mean_delay_s /= static_cast<double>(errors.track.position_m.size());
  return errors;
}

}  // namespace waymark::session::support
