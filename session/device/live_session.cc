// SPDX-License-Identifier: Apache-2.0
// The worker: what is due. What arrives is in arrivals.cc, images in image_calls.cc.
#include <random>

#include "mapping/base/log.h"
#include "session/device/internal/links.h"
#include "session/device/internal/live_session.h"

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
                         std::uint32_t first_attempt, std::shared_ptr<const Tile> tile)
    : options_(options),
      id_(id),
      tile_(std::move(tile)),
      inbox_(kMaxWaitingMessages, kMaxWaitingBytes),
      join_(first_attempt),
      images_(options.keyframe_interval, options.request_timeout),
      bursts_(options.burst_images),
      tile_desk_(options.keyframe_interval, options.tile_patience),
      sizer_(options.keyframe_interval),
      areas_(options.anchor_radius_m),
      about_(options.about),
      tracker_(options.alignment, options.correction),
      view_(id, areas_.scope()) {}

Result<std::unique_ptr<LiveSession>> LiveSession::Start(const DeviceOptions& options) {
  const DeviceId id =
      options.id.value_or(DeviceId(FormatUuid(UuidFromBits(RandomBits(), RandomBits()))));
  std::shared_ptr<const Tile> tile;
  if (!options.tile_folder.empty()) {
    WAYMARK_TRY_ASSIGN(tile, Tile::Open(options.tile_folder));
  }
  std::unique_ptr<LiveSession> session(
      new LiveSession(options, id, static_cast<std::uint32_t>(RandomBits()), std::move(tile)));
  WAYMARK_TRY_ASSIGN(
      session->link_,
      MakeLink(options, id, [inbox = &session->inbox_](wire::DeviceLink::Event event) {
        const std::size_t weight = WeightOf(event);
        inbox->TryPush(std::move(event), weight);
      }));
  session->worker_ = std::thread([raw = session.get()] { raw->Work(); });
  session->image_thread_ = std::thread([raw = session.get()] { raw->WorkOnImages(); });
  return session;
}

LiveSession::~LiveSession() { Leave(); }

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
    image_due_.notify_one();  // it may be connected now
    // Sent away: the way to the server is closed, and what still comes is not listened to.
    if (is_over && !std::exchange(has_gone, true)) link_->SayFarewell();
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
                            .token = options_.token,
                            .owner_secret = options_.owner_secret,
                            .anchor_scope = areas_.scope()});
  }
  if (join_.TakePingDue(now)) {
    (void)link_->Send(ClockPing{.ticket = join_.welcome()->ticket,
                                .sequence_number = next_ping_number_++,
                                .sent = SteadyNow()});
  }
  SendEdits(now);
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
  SayArea(now);
  if (images_.TakeTimeout(now)) {
    ++statistics_.timeouts;
    sizer_.OnTooSlow();
  }
  if (now - last_refresh_ > kRefreshInterval) {
    tracker_.Refresh(tracker_.Pose(0).time);
    last_refresh_ = now;
  }
}

Instant LiveSession::NextDeadline() const {
  Instant next = std::min(join_.NextDeadline(), images_.NextDeadline());
  next = std::min(next, edits_.NextDeadline());
  if (join_.IsConnected()) next = std::min(next, commands_.NextDeadline());
  return std::min(next, std::chrono::steady_clock::now() + kRefreshInterval);
}

}  // namespace waymark::session::internal
