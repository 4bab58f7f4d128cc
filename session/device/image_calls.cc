// SPDX-License-Identifier: Apache-2.0
// Images of a device session: taken, sent and answered.
#include <cstdint>

#include "mapping/base/log.h"
#include "mapping/features/feature_codec.h"
#include "mapping/geometry/resized_camera.h"
#include "session/device/internal/live_session.h"
#include "session/device/jpeg.h"

namespace waymark::session::internal {
namespace {

// Larger images are found hardly more often: see README.md.
constexpr int kMaxFeatureSide_px = 640;
constexpr std::size_t kBytesPerFeature = 144;

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
    if (frame.gnss) about_ = frame.gnss;
    bursts_.Observe(frame.vo_from_device, frame.time);
    gaze_in_device_ = frame.device_from_camera.rotation() * Eigen::Vector3d::UnitZ();
    const Instant now = std::chrono::steady_clock::now();
    if (IsTileCurrent()) tile_desk_.Offer(frame, now, join_.IsConnected());
    const std::size_t waiting = link_->WaitingImageBytes();
    switch (images_.Offer(frame, now, waiting, ExpectedBytes())) {
      case ImageDesk::Offered::kRefused:
        break;
      case ImageDesk::Offered::kTaken:
        tile_desk_.OnAsked(now);
        break;
      case ImageDesk::Offered::kInsteadOfOlder:
        ++statistics_.superseded;
        sizer_.OnTooSlow();
        break;
    }
  }
  image_due_.notify_one();
  return {};
}

/// Of the next image; as large as can be where that is not known.
std::size_t LiveSession::ExpectedBytes() const {
  if (options_.keyframe_content == KeyframeContent::kFeatures) {
    return kBytesPerFeature * static_cast<std::size_t>(options_.max_sent_features);
  }
  const bool is_adaptive = options_.keyframe_sizes == KeyframeSizes::kAdaptive;
  return is_adaptive ? sizer_.ExpectedBytes() : SIZE_MAX;
}

/// A tile of another release is in another frame.
bool LiveSession::IsTileCurrent() const {
  if (!tile_) return false;
  const SessionMap map = CurrentMap();
  return tile_->map().id == map.id && tile_->map().epoch == map.epoch;
}

void LiveSession::WorkOnImages() {
  while (true) {
    {
      std::unique_lock lock(mutex_);
      image_due_.wait(lock, [this] {
        return is_stopping_ || tile_desk_.HasFrame() || (images_.HasFrame() && join_.IsConnected());
      });
      if (is_stopping_) return;
    }
    SendFrame();
    AskTile();
  }
}

void LiveSession::AskTile() {
  std::optional<DeviceFrame> frame;
  {
    const std::lock_guard lock(mutex_);
    frame = tile_desk_.TakeFrame();
  }
  if (!frame) return;
  const localiser::Localisation answer = tile_->Localise(*frame);
  const std::lock_guard lock(mutex_);
  const SentFrame asked = tile_desk_.Finish();
  if (!answer.pose) {
    ++statistics_.tile_refusals;
  } else if (IsTileCurrent()) {
    tracker_.AddFix(asked, *answer.pose, FixSource::kTile);
    ++statistics_.tile_fixes;
  }
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
    bursts_.Ask(*frame, *query);
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

Result<LiveSession::Encoded> LiveSession::EncodeAsFeatures(const DeviceFrame& frame,
                                                           int max_features) {
  WAYMARK_TRY_ASSIGN(const mapping::ImageFeatures features,
                     mapping::ExtractFeatures(
                         {frame.width_px, frame.height_px, frame.pixels},
                         {.max_features = max_features, .max_image_side_px = kMaxFeatureSide_px}));
  return Encoded{mapping::EncodeFeatures(features), frame.width_px, frame.height_px};
}

Result<LiveSession::Encoded> LiveSession::Encode(const DeviceFrame& frame) {
  if (options_.keyframe_content == KeyframeContent::kFeatures) {
    return EncodeAsFeatures(frame, options_.max_sent_features);
  }
  ImageSize size{.quality = options_.jpeg_quality};
  if (options_.keyframe_sizes == KeyframeSizes::kAdaptive) {
    const std::lock_guard lock(mutex_);
    size = sizer_.Choose();
  }
  WAYMARK_TRY_ASSIGN(EncodedImage image,
                     EncodeJpeg(frame.pixels, frame.width_px, frame.height_px, size));
  const std::lock_guard lock(mutex_);
  sizer_.OnEncoded(size, image.jpeg.size());
  return Encoded{std::move(image.jpeg), image.width_px, image.height_px};
}

Result<void> LiveSession::Send(const DeviceFrame& frame, LocaliseQuery query) {
  WAYMARK_TRY_ASSIGN(Encoded image, Encode(frame));
  {
    const std::lock_guard lock(mutex_);
    images_.NoteSent(image.bytes.size(), image.width_px, std::chrono::steady_clock::now());
  }
  query.camera = ResizeCamera(frame.camera, image.width_px, image.height_px);
  query.image = std::move(image.bytes);
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
  tile_desk_.OnAnswer(answer.status == LocaliseStatus::kBusy);
  bursts_.OnAnswer(answer.request, answer.status);
  Judge(answer, *match);
  const std::optional<localiser::LocalisedPose> pose = InLiveMap(answer);
  if (!pose) {
    ++statistics_.refusals;
    return;
  }
  tracker_.AddFix(match->frame, *pose);
  ++statistics_.fixes;
  if (pose->images > 1) ++statistics_.burst_fixes;
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
                        .width_px = match.width_px,
                        .images = answer.pose ? answer.pose->images : 1};
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
