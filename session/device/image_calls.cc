// SPDX-License-Identifier: Apache-2.0
// Images of a device session: taken, sent and answered.
#include <cstdint>

#include "mapping/base/log.h"
#include "session/device/internal/live_session.h"
#include "session/device/jpeg.h"

namespace waymark::session::internal {
namespace {

/// Odometry knows gravity: its z is up.
Eigen::Vector3d UpInCamera(const DeviceFrame& frame) {
  if (frame.up_in_camera) return *frame.up_in_camera;
  return (frame.vo_from_device * frame.device_from_camera).rotation().conjugate() *
         Eigen::Vector3d::UnitZ();
}

}  // namespace

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
    if (!standing_.is_in) return NotIn();
    gaze_in_device_ = frame.device_from_camera.rotation() * Eigen::Vector3d::UnitZ();
    const std::size_t waiting = link_->WaitingImageBytes();
    const bool is_adaptive = options_.keyframe_sizes == KeyframeSizes::kAdaptive;
    const std::size_t next = is_adaptive ? sizer_.ExpectedBytes() : SIZE_MAX;
    switch (images_.Offer(frame, std::chrono::steady_clock::now(), waiting, next)) {
      case ImageDesk::Offered::kRefused:
        return {};
      case ImageDesk::Offered::kTaken:
        break;
      case ImageDesk::Offered::kInsteadOfOlder:
        ++statistics_.superseded;
        sizer_.OnTooSlow();
        break;
    }
  }
  inbox_.Push(WakeUp{});
  return {};
}

void LiveSession::SendFrame() {
  RequestNumber request{};
  std::optional<DeviceFrame> frame;
  std::optional<LocaliseQuery> query;
  {
    const std::lock_guard lock(mutex_);
    if (!join_.IsConnected()) return;
    frame = images_.TakeFrame(request);
    if (!frame) return;
    query = MakeQuery(*frame, request);
  }
  const Result<void> sent = Send(*frame, *std::move(query));
  const std::lock_guard lock(mutex_);
  if (sent.ok()) {
    ++statistics_.keyframes_sent;
    return;
  }
  LogWarning("keyframe not sent: {}", ToString(sent.error()));
  images_.Abandon();
}

Result<void> LiveSession::Send(const DeviceFrame& frame, LocaliseQuery query) {
  ImageSize size{.quality = options_.jpeg_quality};
  if (options_.keyframe_sizes == KeyframeSizes::kAdaptive) {
    const std::lock_guard lock(mutex_);
    size = sizer_.Choose();
  }
  WAYMARK_TRY_ASSIGN(EncodedImage image,
                     EncodeJpeg(frame.pixels, frame.width_px, frame.height_px, size));
  {
    const std::lock_guard lock(mutex_);
    sizer_.OnEncoded(size, image.jpeg.size());
    images_.NoteSent(image.jpeg.size(), image.width_px, std::chrono::steady_clock::now());
  }
  query.camera = ResizeCamera(frame.camera, image.width_px, image.height_px);
  query.image = std::move(image.jpeg);
  return link_->Send(std::move(query));
}

LocaliseQuery LiveSession::MakeQuery(const DeviceFrame& frame, RequestNumber request) const {
  const Welcome& welcome = *join_.welcome();
  LocaliseQuery query{.ticket = welcome.ticket,
                      .request = request,
                      .time = frame.time,
                      .camera = frame.camera,
                      .prior = std::nullopt,
                      .up_in_camera = UpInCamera(frame),
                      .image = {}};
  if (frame.gnss && welcome.map.is_geo_aligned) {
    query.prior = GeoPrior{.position = *frame.gnss, .sigma_m = frame.gnss_sigma_m};
  }
  return query;
}

void LiveSession::On(const LocaliseAnswer& answer) {
  const std::optional<ImageDesk::Match> match = images_.TakeMatch(answer.request);
  if (!match) return;
  Judge(answer, *match);
  const std::optional<localiser::LocalisedPose> pose = InLiveMap(answer);
  if (!pose) {
    ++statistics_.refusals;
    return;
  }
  tracker_.AddFix(match->frame, *pose);
  ++statistics_.fixes;
}

/// What the answer tells of the network and of the image's size.
void LiveSession::Judge(const LocaliseAnswer& answer, const ImageDesk::Match& match) {
  constexpr std::size_t kMaxTimings = 3600;
  const Instant now = std::chrono::steady_clock::now();
  const auto ms = [](auto duration) { return 1e3 * Seconds(duration); };
  KeyframeTiming timing{.total_ms = ms(now - match.pushed),
                        .encode_ms = ms(match.sent - match.pushed),
                        .queue_ms = answer.queue_ms,
                        .features_ms = answer.times.features_ms,
                        .search_ms = answer.times.search_ms,
                        .pose_ms = answer.times.pose_ms,
                        .server_ms = ms(answer.sent - answer.received),
                        .image_bytes = match.image_bytes,
                        .width_px = match.width_px};
  const auto session_now = session_clock_.ToSession(SteadyNow());
  if (session_now) timing.downlink_ms = ms(*session_now - answer.sent);
  timing.uplink_ms = timing.total_ms - timing.encode_ms - timing.server_ms - timing.downlink_ms;
  const auto round_trip = session_clock_.Delay();
  if (round_trip && answer.status != LocaliseStatus::kBusy) {
    sizer_.OnArrived(match.image_bytes, 1e-3 * timing.uplink_ms - 0.5 * Seconds(*round_trip));
    sizer_.OnAnswer(answer.status == LocaliseStatus::kLocalised);
  }
  if (answer.status != LocaliseStatus::kLocalised) return;
  auto& timings = statistics_.keyframe_timings;
  if (timings.size() == kMaxTimings) timings.erase(timings.begin());
  timings.push_back(timing);
}

// An answer may come from the release before: its submap carries it over.
std::optional<localiser::LocalisedPose> LiveSession::InLiveMap(const LocaliseAnswer& answer) const {
  if (!answer.pose || answer.epoch == join_.welcome()->map.epoch) return answer.pose;
  const auto placed = placements_.find(answer.pose->submap);
  if (placed == placements_.end()) return std::nullopt;
  localiser::LocalisedPose pose = *answer.pose;
  pose.map_from_camera = CarryPose(placed->second, pose.submap_from_camera);
  return pose;
}

}  // namespace waymark::session::internal
