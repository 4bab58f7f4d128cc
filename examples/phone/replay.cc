// SPDX-License-Identifier: Apache-2.0
#include "examples/phone/replay.h"

#include <algorithm>
#include <thread>

#include "mapping/base/file.h"
#include "mapping/base/log.h"
#include "mapping/base/quantile.h"
#include "mapping/features/features.h"

namespace waymark::phone {
namespace {

constexpr double kBetweenWords_s = 5;

using SteadyTime = std::chrono::steady_clock::time_point;

Result<session::DeviceFrame> LoadFrame(const Walk& walk, const WalkFrame& frame) {
  WAYMARK_TRY_ASSIGN(const auto bytes, LoadFile(frame.path));
  auto image = mapping::DecodeGrayImage(bytes);
  if (!image) {
    return MakeError(image.error().code, "{}: {}", frame.path.string(), image.error().message);
  }
  return session::DeviceFrame{.width_px = image->width_px,
                              .height_px = image->height_px,
                              .pixels = std::move(image->pixels),
                              .camera = walk.camera,
                              .device_from_camera = walk.device_from_camera,
                              .vo_from_device = frame.vo_from_device,
                              .time = frame.time,
                              .gnss = frame.gnss,
                              .gnss_sigma_m = frame.gnss_sigma_m};
}

std::optional<session::ExpectedDistance> MedianOf(
    const std::vector<session::Agreement>& agreements) {
  if (agreements.empty()) return std::nullopt;
  std::vector<double> p50_m, p95_m;
  for (const auto& agreement : agreements) {
    p50_m.push_back(agreement.apart.p50_m);
    p95_m.push_back(agreement.apart.p95_m);
  }
  return session::ExpectedDistance{Quantile(p50_m, 0.5), Quantile(p95_m, 0.5)};
}

/// The walk's clock laid over this machine's.
class Pace {
 public:
  explicit Pace(DeviceTime first) : first_(first), start_(std::chrono::steady_clock::now()) {}

  double SecondsInto(DeviceTime time) const { return Seconds(time - first_); }
  void WaitFor(DeviceTime time) const { std::this_thread::sleep_until(start_ + (time - first_)); }

 private:
  DeviceTime first_;
  SteadyTime start_;
};

class Player {
 public:
  Player(const Walk& walk, session::DeviceSession& device, const ReplayOptions& options)
      : walk_(walk), device_(device), options_(options), pace_(FirstInstant(walk)) {}

  Result<Replay> Play(const std::atomic<bool>& stop) {
    auto odometry = walk_.odometry.begin();
    for (const WalkFrame& frame : walk_.frames) {
      for (; odometry != walk_.odometry.end() && odometry->time <= frame.time; ++odometry) {
        if (stop) return Finish();
        pace_.WaitFor(odometry->time);
        device_.PushOdometry(odometry->vo_from_device, odometry->time);
      }
      pace_.WaitFor(frame.time);
      WAYMARK_TRY(TakeFrame(frame));
    }
    return Finish();
  }

 private:
  static DeviceTime FirstInstant(const Walk& walk) {
    return std::min(walk.odometry.front().time, walk.frames.front().time);
  }

  Result<void> TakeFrame(const WalkFrame& frame) {
    const double seconds = pace_.SecondsInto(frame.time);
    device_.PushOdometry(frame.vo_from_device, frame.time);
    Record(frame.name, seconds);
    WAYMARK_TRY_ASSIGN(const auto image, LoadFrame(walk_, frame));
    WAYMARK_TRY(device_.PushFrame(image));
    PlaceAnchorWhenDue(seconds);
    return {};
  }

  void Record(const std::string& image, double seconds) {
    TrackPoint point{.image = image, .seconds = seconds, .pose = device_.Pose()};
    const auto others = device_.Others();
    for (const auto& other : others) {
      if (!other.is_present || !other.map_from_device) continue;
      ++point.others_present;
      point.oldest_other_s = std::max(point.oldest_other_s, other.age.count());
    }
    const auto anchors = device_.Anchors();
    for (const auto& anchor : anchors) NoteSighting(anchor.id, seconds);
    point.apart = MedianOf(session::ExpectAgreements(point.pose, others, anchors));
    Tell(point);
    replay_.track.push_back(std::move(point));
  }

  /// What an app would show in a corner, now and then.
  void Tell(const TrackPoint& point) {
    if (!point.apart || point.seconds < told_s_ + kBetweenWords_s) return;
    told_s_ = point.seconds;
    LogInfo("{:.0f} s: {} others; anchors are {:.2f} m from where others show them, 95 %: {:.2f} m",
            point.seconds, point.others_present, point.apart->p50_m, point.apart->p95_m);
  }

  void NoteSighting(const AnchorId& id, double seconds) {
    const bool is_known = std::any_of(replay_.sightings.begin(), replay_.sightings.end(),
                                      [&](const AnchorSighting& s) { return s.id == id; });
    if (!is_known) replay_.sightings.push_back({id, seconds});
  }

  void PlaceAnchorWhenDue(double seconds) {
    if (options_.place_anchor_after_s < 0 || seconds < options_.place_anchor_after_s) return;
    if (replay_.placed || device_.Pose().state != localiser::AlignmentState::kFixed) return;
    const auto anchor = device_.PlaceAnchor(options_.device_from_anchor, options_.anchor_kind,
                                            "Meet me here", options_.audience);
    if (anchor) {
      replay_.placed = anchor->id;
      NoteSighting(anchor->id, seconds);
    } else {
      replay_.place_error = ToString(anchor.error());
    }
  }

  Replay Finish() {
    replay_.anchors = device_.Anchors();
    return std::move(replay_);
  }

  const Walk& walk_;
  session::DeviceSession& device_;
  const ReplayOptions& options_;
  Pace pace_;
  double told_s_ = -kBetweenWords_s;
  Replay replay_;
};

}  // namespace

Result<Replay> ReplayWalk(const Walk& walk, session::DeviceSession& device,
                          const ReplayOptions& options, const std::atomic<bool>& stop) {
  return Player(walk, device, options).Play(stop);
}

}  // namespace waymark::phone
