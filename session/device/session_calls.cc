// SPDX-License-Identifier: Apache-2.0
// The application's half of a device session: coming, going and where everybody is.
#include <cmath>
#include <cstdint>

#include "session/device/agreement.h"
#include "session/device/internal/live_session.h"
#include "session/wire/slices.h"

namespace waymark::session {
namespace internal {
namespace {

constexpr std::chrono::milliseconds kMinReportInterval{15};  // 60 Hz reach others as they are

}  // namespace

std::string LiveSession::ServerName() const {
  if (options_.server.find("://") != std::string::npos) return "gateway " + options_.server;
  if (options_.dds_slices > 1) {
    return fmt::format("server {} (DDS domain {}, slice {} of {})", options_.server,
                       options_.dds_domain, wire::SliceOf(options_.room, options_.dds_slices),
                       options_.dds_slices);
  }
  return fmt::format("server {} (DDS domain {})", options_.server, options_.dds_domain);
}

Result<void> LiveSession::AwaitWelcome() {
  std::unique_lock lock(mutex_);
  const bool is_answered = changed_.wait_for(lock, options_.request_timeout, [this] {
    return join_.welcome().has_value() || refusal_.has_value();
  });
  if (join_.welcome() || (!is_answered && tile_)) return {};
  if (!is_answered) {
    return MakeError(ErrorCode::kUnavailable,
                     "{}: no answer within {} s; is waymark-serve running there?", ServerName(),
                     options_.request_timeout.count());
  }
  const ErrorCode code = refusal_->verdict == JoinVerdict::kInvalid   ? ErrorCode::kInvalidArgument
                         : refusal_->verdict == JoinVerdict::kRefused ? ErrorCode::kConflict
                                                                      : ErrorCode::kUnavailable;
  return MakeError(code, "{}: {}", ServerName(), refusal_->reason);
}

void LiveSession::Leave() {
  {
    const std::lock_guard lock(mutex_);
    if (has_left_) return;
    has_left_ = true;
    is_stopping_ = true;
  }
  image_due_.notify_all();
  inbox_.Close();
  if (worker_.joinable()) worker_.join();
  if (link_) link_->SayFarewell();
  changed_.notify_all();
  if (image_thread_.joinable()) image_thread_.join();
}

void LiveSession::PushOdometry(const Transform<Vo, Device>& vo_from_device, DeviceTime time) {
  std::optional<PoseReport> report;
  {
    const std::lock_guard lock(mutex_);
    if (const auto jump = stamp_clock_.Observe(time, SteadyNow())) {
      tracker_.ShiftTime(*jump);
      images_.ShiftTime(*jump);
      bursts_.ShiftTime(*jump);
      tile_desk_.ShiftTime(*jump);
      ++statistics_.clock_jumps;
    }
    tracker_.PushOdometry(vo_from_device, time);
    bursts_.Observe(vo_from_device, time);
    const bool is_due = time - last_report_ >= kMinReportInterval || time < last_report_;
    const bool may_share = join_.welcome() && MaySharePose(standing_.role);
    if (has_left_ || !join_.IsConnected() || !may_share || !is_due) return;
    const DevicePose pose = CurrentPose();
    const std::optional<ServerTime> session_time = session_clock_.ToSession(ToSteady(time));
    if (!pose.map_from_device || !session_time) return;
    const PoseCertainty certainty = CertaintyOf(pose.covariance);
    report =
        PoseReport{.ticket = join_.welcome()->ticket,
                   .pose = {.epoch = pose.epoch,
                            .time = *session_time,
                            .map_from_device = *pose.map_from_device,
                            .sigma_m = certainty.sigma_m,
                            .rotation_sigma_rad = certainty.rotation_sigma_rad,
                            .tracking = pose.state,
                            .velocity_in_map = tracker_.VelocityInMap(),
                            .gaze_in_map = pose.map_from_device->rotation() * gaze_in_device_}};
    last_report_ = time;
  }
  (void)link_->Send(*report);  // the next one is better anyway
}

/// As the server last said; the tile's before it ever did.
SessionMap LiveSession::CurrentMap() const {
  if (!join_.welcome()) return tile_ ? tile_->map() : SessionMap{};
  const MapIdentity& map = join_.welcome()->map;
  return {.id = map.map,
          .is_geo_aligned = map.is_geo_aligned,
          .origin = map.origin,
          .epoch = map.epoch};
}

DevicePose LiveSession::CurrentPose() const { return tracker_.Pose(CurrentMap().epoch); }

/// Where the stamps' clock can be read, it is exact, whatever it was set to meanwhile.
DeviceTime LiveSession::ToSteady(DeviceTime stamp) const {
  if (!options_.clock) return stamp_clock_.ToSteady(stamp);
  return SteadyNow() - (options_.clock() - stamp);
}

ServerTime LiveSession::SessionNow() const {
  return session_clock_.ToSession(SteadyNow()).value_or(ServerTime{});
}

DevicePose LiveSession::Pose() const {
  const std::lock_guard lock(mutex_);
  return CurrentPose();
}

std::optional<ServerTime> LiveSession::SessionTime(DeviceTime instant) const {
  const std::lock_guard lock(mutex_);
  return session_clock_.ToSession(ToSteady(instant));
}

SessionMap LiveSession::DescribeMap() const {
  const std::lock_guard lock(mutex_);
  return CurrentMap();
}

std::vector<OtherDevice> LiveSession::Others() const {
  const std::lock_guard lock(mutex_);
  return view_.Others(SessionNow());
}

RoomStanding LiveSession::Standing() const {
  const std::lock_guard lock(mutex_);
  return standing_;
}

Error LiveSession::NotIn() const {
  return MakeError(ErrorCode::kUnavailable, "room {}: {}", options_.room.text(), standing_.reason);
}

DeviceStatistics LiveSession::Statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

}  // namespace internal

Result<std::unique_ptr<DeviceSession>> DeviceSession::Join(const DeviceOptions& options) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY_ASSIGN(auto session, internal::LiveSession::Start(options));
  WAYMARK_TRY(session->AwaitWelcome());
  return std::unique_ptr<DeviceSession>(std::move(session));
}

}  // namespace waymark::session
