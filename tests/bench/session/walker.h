// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "session/state/messages.h"

namespace waymark::bench {

/// The session's clock: server and phones run on this machine and read the same one.
inline ServerTime Now() {
  return ServerTime(std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::steady_clock::now().time_since_epoch()));
}

/// Somebody who walks in a circle of 5 m around a place, together with the others of a group.
class Walker {
 public:
  /// `member` counts those of the group.
  Walker(std::uint64_t group, std::uint64_t member, double edge_m) {
    std::mt19937_64 random(group);
    std::uniform_real_distribution<double> place(-edge_m / 2, edge_m / 2), turn(0, 6.28);
    x_m_ = place(random);
    y_m_ = place(random);
    phase_ = turn(random) + static_cast<double>(member);
  }

  session::LivePose PoseAt(ServerTime time, std::uint64_t epoch = 1) const {
    constexpr double kRadius_m = 5, kSpeed_mps = 1.4;
    const double angle =
        phase_ +
        kSpeed_mps / kRadius_m * std::chrono::duration<double>(time.time_since_epoch()).count();
    const Eigen::Vector3d outward(std::cos(angle), std::sin(angle), 0);
    const Eigen::Vector3d ahead(-outward.y(), outward.x(), 0);
    return {
        .epoch = epoch,
        .time = time,
        .map_from_device = {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())),
                            Eigen::Vector3d(x_m_, y_m_, 1.5) + kRadius_m * outward},
        .sigma_m = 0.05,
        .velocity_in_map = kSpeed_mps * ahead,
        .gaze_in_map = ahead};
  }

 private:
  double x_m_ = 0, y_m_ = 0, phase_ = 0;
};

/// What one phone of a crowd has heard while it was counted.
struct Heard {
  std::vector<ServerTime> sent;  ///< each pose batch that came, in the order of coming
  std::vector<float> ages_ms;    ///< from one phone's report to another's hearing of it
  std::vector<float> legs_ms;    ///< from the server's tick to hearing of it
  std::uint64_t poses = 0;
  std::uint64_t bytes = 0;  ///< of all messages
};

/// What a crowd has heard of another release while it was counted.
struct HeardOfSwap {
  std::optional<ServerTime> first_over, last_over;  ///< phones that heard that it is live
  std::optional<ServerTime> last_anchor;            ///< in its map
  std::uint64_t anchors = 0;                        ///< in its map, told to anybody
};

/// A crowd while it was counted.
struct Walked {
  std::vector<Heard> heard;
  double seconds = 0;          ///< a machine that is too busy takes longer than it was told
  double longest_wait_ms = 0;  ///< of a ping, from when the server had it until its loop answered
  HeardOfSwap swap = {};
};

/// Counts a batch; of the ages every eighth batch, which is plenty.
inline void Count(Heard& heard, const session::PoseBatch& batch) {
  const ServerTime now = Now();
  heard.sent.push_back(batch.time);
  heard.poses += batch.poses.size();
  const auto ms_since = [&](ServerTime time) {
    return static_cast<float>(1e3 * Seconds(now - time));
  };
  heard.legs_ms.push_back(ms_since(batch.time));
  if (heard.sent.size() % 8 != 1) return;
  for (const session::SharedPose& shared : batch.poses) {
    heard.ages_ms.push_back(ms_since(shared.pose.time));
  }
}

}  // namespace waymark::bench
