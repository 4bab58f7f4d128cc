// SPDX-License-Identifier: Apache-2.0
// The worker's half: what arrives, and what is due. The application's half is in session_calls.cc.
#include <random>

#include "mapping/base/log.h"
#include "session/device/internal/links.h"
#include "session/device/internal/live_session.h"
#include "session/device/jpeg.h"

namespace waymark::session::internal {
namespace {

constexpr std::size_t kMaxWaitingMessages = 65'536;  // a room's whole snapshot at once
constexpr std::size_t kMaxWaitingBytes = 256 * 1024 * 1024;
constexpr std::chrono::seconds kRefreshInterval{1};

std::uint64_t RandomBits() {
  std::random_device device;
  return std::uint64_t{device()} << 32 | device();
}

std::size_t WeightOf(const wire::DeviceLink::Event& event) {
  const auto* message = std::get_if<wire::Downward>(&event);
  const auto* state = message ? std::get_if<AnchorState>(message) : nullptr;
  return state == nullptr ? 0 : state->anchor.record.payload.size();
}

}  // namespace

LiveSession::LiveSession(const DeviceOptions& options, const DeviceId& id,
                         std::uint32_t first_attempt)
    : options_(options),
      id_(id),
      inbox_(kMaxWaitingMessages, kMaxWaitingBytes),
      join_(first_attempt),
      images_(options.keyframe_interval, options.request_timeout),
      sizer_(options.keyframe_interval),
      tracker_(options.alignment, options.correction),
      view_(id) {}

Result<std::unique_ptr<LiveSession>> LiveSession::Start(const DeviceOptions& options) {
  const DeviceId id =
      options.id.value_or(DeviceId(FormatUuid(UuidFromBits(RandomBits(), RandomBits()))));
  std::unique_ptr<LiveSession> session(
      new LiveSession(options, id, static_cast<std::uint32_t>(RandomBits())));
  WAYMARK_TRY_ASSIGN(
      session->link_,
      MakeLink(options, id, [inbox = &session->inbox_](wire::DeviceLink::Event event) {
        const std::size_t weight = WeightOf(event);
        inbox->TryPush(std::move(event), weight);
      }));
  session->worker_ = std::thread([raw = session.get()] { raw->Work(); });
  return session;
}

LiveSession::~LiveSession() { Leave(); }

// ---- the worker -------------------------------------------------------------------------------

void LiveSession::Work() {
  Instant deadline = std::chrono::steady_clock::now();
  bool has_gone = false;
  while (!is_stopping_) {
    const std::vector<Item> items = inbox_.TakeAll(deadline);
    bool is_over = false;
    {
      const std::lock_guard lock(mutex_);
      for (const Item& item : items) {
        const auto* const event = std::get_if<wire::DeviceLink::Event>(&item);
        if (event && !join_.IsOver()) On(*event);
      }
      SendWhatIsDue();
      is_over = join_.IsOver();
    }
    changed_.notify_all();
    // Sent away: the way to the server is closed, and what still comes is not listened to.
    if (is_over && !std::exchange(has_gone, true)) link_->SayFarewell();
    SendFrame();
    const std::lock_guard lock(mutex_);
    deadline = NextDeadline();
  }
}

void LiveSession::SendWhatIsDue() {
  const Instant now = std::chrono::steady_clock::now();
  // What cannot be sent now is due again soon: nothing here is said only once.
  if (join_.TakeHelloDue(now)) {
    (void)link_->Send(Hello{.device = id_,
                            .protocol = kProtocol,
                            .attempt = join_.attempt(),
                            .room = options_.room,
                            .name = options_.name,
                            .token = options_.token});
  }
  if (join_.TakeLongSilence(now)) view_.BeginResync();
  if (join_.TakePingDue(now)) {
    (void)link_->Send(ClockPing{.ticket = join_.welcome()->ticket,
                                .sequence_number = next_ping_number_++,
                                .sent = SteadyNow()});
  }
  if (join_.IsConnected()) {
    for (Command& due : commands_.TakeDue(now)) {
      std::visit(
          [this](auto& command) {
            command.ticket = join_.welcome()->ticket;
            (void)link_->Send(command);
          },
          due);
    }
  }
  if (images_.TakeTimeout(now)) {
    ++statistics_.timeouts;
    sizer_.OnTooSlow();
  }
  if (now - last_refresh_ > kRefreshInterval) {
    tracker_.Refresh(tracker_.Pose(0).time);
    last_refresh_ = now;
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
                      // Odometry knows gravity: its z is up.
                      .up_in_camera = Eigen::Vector3d(
                          (frame.vo_from_device * frame.device_from_camera).rotation().conjugate() *
                          Eigen::Vector3d::UnitZ()),
                      .image = {}};
  if (frame.gnss && welcome.map.is_geo_aligned) {
    query.prior = GeoPrior{.position = *frame.gnss, .sigma_m = frame.gnss_sigma_m};
  }
  return query;
}

Instant LiveSession::NextDeadline() const {
  Instant next = std::min(join_.NextDeadline(), images_.NextDeadline());
  if (join_.IsConnected()) next = std::min(next, commands_.NextDeadline());
  return std::min(next, std::chrono::steady_clock::now() + kRefreshInterval);
}

// ---- what arrives -----------------------------------------------------------------------------

void LiveSession::On(const wire::DeviceLink::Event& event) {
  if (const auto* message = std::get_if<wire::Downward>(&event)) {
    return std::visit([this](const auto& content) { On(content); }, *message);
  }
  join_.Restart(std::chrono::steady_clock::now());
  view_.BeginResync();  // what ended meanwhile is not told
  images_.Abandon();    // a newer one is better than one that may never be answered
}

void LiveSession::On(const Welcome& welcome) {
  const std::optional<Welcome> before = join_.welcome();
  switch (join_.On(welcome, std::chrono::steady_clock::now())) {
    case JoinDesk::Outcome::kIgnored:
      return;
    case JoinDesk::Outcome::kRefused:
      refusal_ = welcome;
      standing_.is_in = false;  // it asks again
      standing_.reason = welcome.reason;
      return;
    case JoinDesk::Outcome::kRemoved:
      standing_.is_in = false;
      standing_.reason = welcome.reason;
      LogWarning("room {}: {}", options_.room.text(), welcome.reason);
      return;
    case JoinDesk::Outcome::kJoined:
      break;
  }
  ++statistics_.joins;
  standing_.is_in = true;
  standing_.reason.clear();
  standing_.role = welcome.role;
  if (welcome.is_return) ++standing_.returns;
  if (before && (before->map.map != welcome.map.map || before->map.epoch != welcome.map.epoch)) {
    tracker_.Reset();  // the fixes are in the frame of another release
  }
  if (!before || before->run != welcome.run) {
    session_clock_.Clear();
    last_swap_ = 0;
  }
  view_.StartRun(welcome.run, welcome.map.epoch);
}

void LiveSession::On(const wire::DeviceGone& gone) { view_.OnGone(gone.device, SessionNow()); }

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

void LiveSession::On(const MapState& state) {
  const auto& welcome = join_.welcome();
  if (!welcome || state.run != welcome->run || state.swap <= last_swap_) return;
  last_swap_ = state.swap;
  placements_ = state.placements;
  if (state.epoch == welcome->map.epoch) return;  // welcomed after it
  join_.SetEpoch(state.epoch);
  (void)tracker_.CarryTo(state.placements);
  view_.CarryTo(state.epoch, state.placements);
  ++statistics_.map_changes;
}

void LiveSession::On(const CommandReply& reply) {
  if (!commands_.On(reply)) return;
  if (reply.outcome == CommandOutcome::kApplied && reply.current) view_.OnOwnChange(*reply.current);
}

void LiveSession::On(const ClockPong& pong) {
  join_.OnPong(pong, std::chrono::steady_clock::now());
  session_clock_.Add({.device_sent = pong.device_sent,
                      .server_received = pong.received,
                      .server_sent = pong.sent,
                      .device_received = SteadyNow()});
}

}  // namespace waymark::session::internal
