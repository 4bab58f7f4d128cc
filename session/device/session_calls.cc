// SPDX-License-Identifier: Apache-2.0
// The application's half of a device session.
#include <cmath>
#include <random>

#include "session/device/internal/live_session.h"

namespace waymark::session {
namespace internal {
namespace {

constexpr std::chrono::milliseconds kMinReportInterval{15};  // 60 Hz reach others as they are

Uuid MakeUuid() {
  std::random_device device;
  const auto bits = [&device] { return std::uint64_t{device()} << 32 | device(); };
  return UuidFromBits(bits(), bits());
}

Result<void> CheckContent(const std::string& kind, const std::string& payload) {
  if (kind.size() > kMaxKindBytes) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "anchor kind: expected at most {} bytes, found {}", kMaxKindBytes,
                     kind.size());
  }
  if (payload.size() > kMaxPayloadBytes) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "anchor payload: expected at most {} bytes, found {}", kMaxPayloadBytes,
                     payload.size());
  }
  return {};
}

Error ToError(const CommandReply& reply) {
  const auto code = [&] {
    switch (reply.outcome) {
      case CommandOutcome::kConflict:
        return ErrorCode::kConflict;
      case CommandOutcome::kNotFound:
        return ErrorCode::kNotFound;
      case CommandOutcome::kInvalid:
        return ErrorCode::kInvalidArgument;
      case CommandOutcome::kApplied:
      case CommandOutcome::kUnavailable:
        break;
    }
    return ErrorCode::kUnavailable;
  };
  return Error{code(), reply.reason};
}

}  // namespace

std::string LiveSession::ServerName() const {
  return fmt::format("server {} (DDS domain {})", options_.server, options_.dds_domain);
}

Result<void> LiveSession::AwaitWelcome() {
  std::unique_lock lock(mutex_);
  const bool is_answered = changed_.wait_for(lock, options_.request_timeout, [this] {
    return join_.welcome().has_value() || refusal_.has_value();
  });
  if (join_.welcome()) return {};
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
  }
  is_stopping_ = true;
  inbox_.Close();
  if (worker_.joinable()) worker_.join();
  if (bus_) bus_->SayFarewell();
  changed_.notify_all();
}

// ---- where we are -----------------------------------------------------------------------------

Result<void> LiveSession::PushFrame(const DeviceFrame& frame) {
  const auto expected = static_cast<std::int64_t>(frame.width_px) * frame.height_px;
  if (frame.width_px <= 0 || frame.height_px <= 0 ||
      static_cast<std::int64_t>(frame.pixels.size()) != expected) {
    return MakeError(ErrorCode::kInvalidArgument, "frame: expected {} x {} pixels, found {} bytes",
                     frame.width_px, frame.height_px, frame.pixels.size());
  }
  if (frame.camera.width_px() != frame.width_px || frame.camera.height_px() != frame.height_px) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "frame: has {} x {} pixels, but its camera {} x {}", frame.width_px,
                     frame.height_px, frame.camera.width_px(), frame.camera.height_px());
  }
  {
    const std::lock_guard lock(mutex_);
    if (has_left_) return MakeError(ErrorCode::kUnavailable, "{}: has been left", ServerName());
    if (!images_.Offer(frame, std::chrono::steady_clock::now())) return {};
  }
  inbox_.Push(WakeUp{});
  return {};
}

void LiveSession::PushOdometry(const Transform<Vo, Device>& vo_from_device, DeviceTime time) {
  std::optional<PoseReport> report;
  {
    const std::lock_guard lock(mutex_);
    tracker_.PushOdometry(vo_from_device, time);
    if (!options_.clock) stamp_clock_.Observe(time, ClockNow());
    const bool is_due = time - last_report_ >= kMinReportInterval || time < last_report_;
    if (has_left_ || !join_.IsConnected() || !is_due) return;
    const DevicePose pose = CurrentPose();
    const std::optional<ServerTime> session_time =
        session_clock_.ToSession(options_.clock ? time : stamp_clock_.ToSteady(time));
    if (!pose.map_from_device || !session_time) return;
    report = PoseReport{
        .ticket = join_.welcome()->ticket,
        .pose = {.epoch = pose.epoch,
                 .time = *session_time,
                 .map_from_device = *pose.map_from_device,
                 .sigma_m = std::sqrt(pose.covariance.topLeftCorner<3, 3>().trace() / 3)}};
    last_report_ = time;
  }
  (void)bus_->Send(*report);  // the next one is better anyway
}

DevicePose LiveSession::CurrentPose() const {
  return tracker_.Pose(join_.welcome() ? join_.welcome()->map.epoch : 0);
}

DeviceTime LiveSession::ClockNow() const {
  if (options_.clock) return options_.clock();
  return DeviceTime(std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::steady_clock::now().time_since_epoch()));
}

ServerTime LiveSession::SessionNow() const {
  return session_clock_.ToSession(ClockNow()).value_or(ServerTime{});
}

DevicePose LiveSession::Pose() const {
  const std::lock_guard lock(mutex_);
  return CurrentPose();
}

SessionMap LiveSession::DescribeMap() const {
  const std::lock_guard lock(mutex_);
  if (!join_.welcome()) return {};
  const MapIdentity& map = join_.welcome()->map;
  return {.id = map.map,
          .is_geo_aligned = map.is_geo_aligned,
          .origin = map.origin,
          .epoch = map.epoch};
}

std::vector<OtherDevice> LiveSession::Others() const {
  const std::lock_guard lock(mutex_);
  return view_.Others(SessionNow());
}

DeviceStatistics LiveSession::Statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

// ---- anchors ----------------------------------------------------------------------------------

Result<CommandReply> LiveSession::Perform(AnchorCommand command) {
  command.request = MakeUuid();
  std::unique_lock lock(mutex_);
  commands_.Add(command, std::chrono::steady_clock::now());
  inbox_.Push(WakeUp{});
  changed_.wait_for(lock, options_.request_timeout,
                    [&] { return has_left_ || commands_.FindReply(command.request) != nullptr; });
  std::optional<CommandReply> reply;
  if (const auto* found = commands_.FindReply(command.request)) reply = *found;
  const CommandDesk::Farewell farewell = commands_.Remove(command.request);
  if (!reply) {
    const std::string why = farewell.last_refusal.empty() ? "" : ": " + farewell.last_refusal;
    return MakeError(ErrorCode::kUnavailable, "{}: no answer about anchor {} within {} s{}",
                     ServerName(), command.anchor.text(), options_.request_timeout.count(), why);
  }
  // It was gone when the repetition came: the first one did it.
  const bool is_own_deletion = command.operation == AnchorOperation::kDelete &&
                               reply->outcome == CommandOutcome::kNotFound && farewell.sent > 1;
  if (is_own_deletion) reply->outcome = CommandOutcome::kApplied;
  if (reply->outcome != CommandOutcome::kApplied) return ToError(*reply);
  return *std::move(reply);
}

Result<SharedAnchor> LiveSession::PlaceAnchor(const Transform<Device, Anchor>& device_from_anchor,
                                              const std::string& kind, const std::string& payload) {
  WAYMARK_TRY(CheckContent(kind, payload));
  AnchorCommand command{.operation = AnchorOperation::kCreate,
                        .anchor = AnchorId(FormatUuid(MakeUuid())),
                        .kind = kind,
                        .payload = payload};
  {
    const std::lock_guard lock(mutex_);
    const DevicePose pose = CurrentPose();
    if (!pose.map_from_device) {
      return MakeError(ErrorCode::kUnavailable,
                       "anchor: this device has not been localised yet, so it has no place");
    }
    command.map_from_anchor = *pose.map_from_device * device_from_anchor;
    command.epoch = pose.epoch;
    command.seen_in = tracker_.SeenIn();
  }
  WAYMARK_TRY_ASSIGN(const CommandReply reply, Perform(command));
  if (reply.current) return ToShared(*reply.current);
  return MakeError(ErrorCode::kNotFound, "anchor {}: was placed and deleted since",
                   command.anchor.text());
}

Result<SharedAnchor> LiveSession::MoveAnchor(const SharedAnchor& anchor,
                                             const Transform<Map, Anchor>& map_from_anchor) {
  AnchorCommand command{.operation = AnchorOperation::kMove,
                        .anchor = anchor.id,
                        .expected_revision = anchor.revision,
                        .epoch = anchor.epoch,
                        .map_from_anchor = map_from_anchor};
  {
    const std::lock_guard lock(mutex_);
    command.seen_in = tracker_.SeenIn();
  }
  WAYMARK_TRY_ASSIGN(const CommandReply reply, Perform(command));
  if (reply.current) return ToShared(*reply.current);
  return MakeError(ErrorCode::kNotFound, "anchor {}: was moved and deleted since",
                   anchor.id.text());
}

Result<void> LiveSession::DeleteAnchor(const SharedAnchor& anchor) {
  WAYMARK_TRY_ASSIGN(const CommandReply reply, Perform({.operation = AnchorOperation::kDelete,
                                                        .anchor = anchor.id,
                                                        .expected_revision = anchor.revision,
                                                        .epoch = anchor.epoch}));
  const std::lock_guard lock(mutex_);
  view_.OnGone(anchor.id);
  return {};
}

std::vector<SharedAnchor> LiveSession::Anchors() const {
  const std::lock_guard lock(mutex_);
  return view_.Anchors();
}

bool LiveSession::HasSnapshot() const {
  const std::lock_guard lock(mutex_);
  return view_.HasSnapshot();
}

}  // namespace internal

Result<void> CorrectionOptions::Validate() const {
  if (max_speed_mps > 0 && max_turn_per_s.radians() > 0 && max_offset_m > 0) return {};
  return MakeError(ErrorCode::kInvalidArgument,
                   "correction: expected speed, turn and offset above 0, found {}, {} rad and {}",
                   max_speed_mps, max_turn_per_s.radians(), max_offset_m);
}

Result<void> DeviceOptions::Validate() const {
  if (jpeg_quality < 30 || jpeg_quality > 100) {
    return MakeError(ErrorCode::kInvalidArgument, "JPEG quality: expected [30, 100], found {}",
                     jpeg_quality);
  }
  if (!(keyframe_interval.count() >= 0) || !(request_timeout.count() > 0)) {
    return MakeError(
        ErrorCode::kInvalidArgument,
        "keyframe interval and request timeout: expected >= 0 and > 0, found {} and {}",
        keyframe_interval.count(), request_timeout.count());
  }
  if (name.size() > kMaxNameBytes) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "device name: expected at most {} bytes, found {}", kMaxNameBytes,
                     name.size());
  }
  WAYMARK_TRY(correction.Validate());
  return alignment.Validate();
}

Result<std::unique_ptr<DeviceSession>> DeviceSession::Join(const DeviceOptions& options) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY_ASSIGN(auto session, internal::LiveSession::Start(options));
  WAYMARK_TRY(session->AwaitWelcome());
  return std::unique_ptr<DeviceSession>(std::move(session));
}

}  // namespace waymark::session
