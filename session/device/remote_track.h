// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <deque>
#include <optional>

#include "session/state/messages.h"

namespace waymark::session {

struct PlayoutOptions {
  /// How long a motion is believed to go on unseen. What comes later than this is waited for, but
  /// not for long: who is shown as he was is shown beside himself (session/README.md has figures).
  std::chrono::duration<double> horizon{0.8};
  std::chrono::duration<double> max_delay{0.1};
  /// How fast a position goes over to what a newer report says, so that nothing jumps; a turn, of
  /// which delay is the worse part, goes over faster.
  std::chrono::duration<double> settling{0.08};
  std::chrono::duration<double> turn_settling{0.03};
};

/// Where another phone is, now: its reports come late, unevenly and sometimes not at all.
///
/// - A buffer delays what is shown by no more than it must: by the lateness that 95 % of the
///   reports keep below, less the horizon, and not for long. It follows changes of the network
///   slowly, so that motion shown does not hurry.
/// - Between two reports the pose is interpolated: a cubic through positions and velocities, and
///   rotation along the great circle. Beyond the last it goes on, ever more slowly, turning about
///   the vertical alone, and its sigmas grow.
///
/// Pure; thread-compatible. Times are the session's.
class RemoteTrack {
 public:
  struct Shown {
    Transform<Map, Device> map_from_device;
    double sigma_m = 0;  ///< of the position: as reported, and what may have happened since
    double rotation_sigma_rad = 0;  ///< likewise, about each axis
  };

  explicit RemoteTrack(const PlayoutOptions& options = {}) : options_(options) {}

  /// Out of order or twice is as good. A pose of another epoch begins anew: it is in another frame.
  void Hear(const LivePose& pose, ServerTime arrived);
  /// Nothing before the first report.
  std::optional<Shown> At(ServerTime now) const;

  /// The newest report.
  const LivePose* latest() const { return heard_.empty() ? nullptr : &heard_.back(); }
  /// By how much it is behind what is true, on purpose.
  std::chrono::duration<double> delay() const { return delay_; }

 private:
  Shown Predict(ServerTime instant) const;
  Shown Extrapolate(ServerTime instant) const;
  void AdaptTo(std::chrono::duration<double> lateness, ServerTime arrived);

  PlayoutOptions options_;
  std::deque<LivePose> heard_;     // by time
  std::deque<double> lateness_s_;  // of the last reports
  std::chrono::duration<double> delay_{0};
  std::optional<ServerTime> arrived_;  // the last one
  // What was shown differed by this from what the newest report says, when it came.
  Eigen::Matrix<double, 6, 1> offset_ = Eigen::Matrix<double, 6, 1>::Zero();
};

}  // namespace waymark::session
