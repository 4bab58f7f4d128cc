// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/crowd.h"

#include <sys/epoll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <thread>
#include <utility>

#include "mapping/base/log.h"
#include "session/wire/frames.h"

namespace waymark::bench {

using namespace session;  // NOLINT: the whole file speaks its language
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::uint64_t kSeed = 0x57a9;
constexpr std::uint32_t kPingEvery = 8;  // reports
constexpr std::uint32_t kAskEvery = 15;  // reports, until it is told of its area

constexpr std::chrono::milliseconds kSlice{1};  // what is due in it is done together

}  // namespace

struct Crowd::Phone {
  WebSocket socket;
  std::uint32_t number;
  Walker walker;
  Hello hello;
  Ticket ticket{};
  std::uint32_t pings = 0;
  std::uint64_t epoch = 1;
  bool knows_area = false;
  Heard heard = {};

  void Say(const wire::Upward& message) { (void)socket.Send(wire::EncodeFrame(message)); }

  void Report(std::uint32_t step, double area_radius_m) {
    const LivePose pose = walker.PoseAt(Now(), epoch);
    Say(PoseReport{ticket, pose});
    if ((step + number) % kPingEvery == 0) Say(ClockPing{ticket, pings++, {}});
    if (area_radius_m <= 0 || knows_area || (step + number) % kAskEvery != 0) return;
    const Eigen::Vector2d here_m = pose.map_from_device.translation().head<2>();
    Say(AreaReport{.ticket = ticket, .number = 1, .area = {here_m, area_radius_m}});
  }
};

Result<std::unique_ptr<Crowd>> Crowd::Connect(std::uint16_t gateway_port, const Options& options) {
  std::unique_ptr<Crowd> crowd(new Crowd(options));
  crowd->poll_ = ::epoll_create1(EPOLL_CLOEXEC);
  const int groups = std::max(1, options.phones / 4);
  for (int i = 0; i < options.phones; ++i) {
    WAYMARK_TRY_ASSIGN(WebSocket socket, WebSocket::Connect(gateway_port, options.is_tls));
    const std::uint64_t number = options.first_phone + static_cast<std::uint64_t>(i);
    crowd->phones_.push_back(std::make_unique<Phone>(
        Phone{.socket = std::move(socket),
              .number = static_cast<std::uint32_t>(i),
              .walker = Walker(static_cast<std::uint64_t>(i % groups),
                               static_cast<std::uint64_t>(i / groups), options.edge_m),
              .hello = {.device = DeviceId(FormatUuid(UuidFromBits(kSeed, number))),
                        .room = RoomId(fmt::format("room{}", number / options.per_room)),
                        .name = fmt::format("phone {}", i),
                        .anchor_scope = AnchorScope::kArea}}));
    epoll_event event{.events = EPOLLIN, .data = {.ptr = crowd->phones_.back().get()}};
    ::epoll_ctl(crowd->poll_, EPOLL_CTL_ADD, crowd->phones_.back()->socket.descriptor(), &event);
  }
  return crowd;
}

Crowd::Crowd(const Options& options) : options_(options) {}
Crowd::~Crowd() { ::close(poll_); }

void Crowd::Listen() {
  std::array<epoll_event, 256> events;
  int count = 0;
  do {
    count = ::epoll_wait(poll_, events.data(), events.size(), 0);
    for (int i = 0; i < count; ++i) {
      auto& phone = *static_cast<Phone*>(events[static_cast<std::size_t>(i)].data.ptr);
      const bool is_open = phone.socket.Receive(
          [&](std::span<const std::uint8_t> message) { OnMessage(phone, message); });
      if (is_open) continue;
      ++lost_;
      ::epoll_ctl(poll_, EPOLL_CTL_DEL, phone.socket.descriptor(), nullptr);
    }
  } while (count == static_cast<int>(events.size()));
}

void Crowd::OnMessage(Phone& phone, std::span<const std::uint8_t> message) {
  if (phone.ticket != Ticket{}) return Count(phone, message);
  constexpr int kWelcome = 17;
  if (message.empty() || message[0] != kWelcome) return;
  const auto decoded = wire::DecodeDownward(message);
  if (!decoded) return;
  const auto* welcome = std::get_if<Welcome>(&*decoded);
  if (welcome == nullptr) return;
  if (welcome->verdict != JoinVerdict::kAccepted) {
    return LogWarning("{}: {}", phone.hello.name, welcome->reason);
  }
  phone.ticket = welcome->ticket;
  phone.epoch = welcome->map.epoch;
  ++welcome_;
}

void Crowd::Count(Phone& phone, std::span<const std::uint8_t> message) {
  if (is_counting_) phone.heard.bytes += message.size();
  constexpr int kAnchor = 21, kMap = 24, kPong = 25, kPoses = 26, kArea = 28;
  const int kind = message.empty() ? 0 : message[0];
  const bool is_known = kind == kMap || kind == kArea || kind == kAnchor;
  if (!is_known && !(is_counting_ && (kind == kPong || kind == kPoses))) return;
  const auto decoded = wire::DecodeDownward(message);
  if (!decoded) return;
  if (const auto* batch = std::get_if<PoseBatch>(&*decoded)) {
    bench::Count(phone.heard, *batch);
  } else if (const auto* pong = std::get_if<ClockPong>(&*decoded)) {
    longest_wait_ms_ = std::max(longest_wait_ms_, 1e3 * Seconds(pong->sent - pong->received));
  } else if (const auto* map = std::get_if<MapState>(&*decoded)) {
    phone.epoch = map->epoch;
    if (!swap_.first_over) swap_.first_over = Now();
    swap_.last_over = Now();
  } else if (const auto* anchor = std::get_if<AnchorState>(&*decoded)) {
    if (!is_counting_ || anchor->anchor.record.epoch == epoch_before_) return;
    swap_.last_anchor = Now();
    ++swap_.anchors;
  } else {
    phone.knows_area = true;
  }
}

Result<double> Crowd::JoinAll() {
  const auto begin = Clock::now();
  while (welcome_ < phones_.size()) {
    if (Clock::now() - begin > std::chrono::minutes(1)) {
      return MakeError(ErrorCode::kTimeout, "{} of {} phones are welcome after a minute", welcome_,
                       phones_.size());
    }
    for (const auto& phone : phones_) {
      if (phone->ticket == Ticket{}) {
        phone->Say(phone->hello);
      } else {
        phone->Say(ClockPing{phone->ticket, phone->pings++, {}});  // who is silent is gone
      }
    }
    const auto again = Clock::now() + std::chrono::milliseconds(300);
    while (welcome_ < phones_.size() && Clock::now() < again) {
      Listen();
      std::this_thread::sleep_for(kSlice);
    }
  }
  return Seconds(Clock::now() - begin);
}

// Phones report one after the other, spread over the period as they are in life.
Walked Crowd::Walk(double seconds) {
  const auto begin = Clock::now();
  const double reports_per_s = options_.hz * static_cast<double>(phones_.size());
  std::uint64_t reports = 0;
  const auto walk_until = [&](double end_s) {
    const auto end = static_cast<std::uint64_t>(end_s * reports_per_s);
    while (reports < end) {
      const double now_s = Seconds(Clock::now() - begin);
      const auto due = std::min(end, static_cast<std::uint64_t>(now_s * reports_per_s));
      for (; reports < due; ++reports) {
        phones_[reports % phones_.size()]->Report(
            static_cast<std::uint32_t>(reports / phones_.size()), options_.area_radius_m);
      }
      Listen();
      std::this_thread::sleep_for(kSlice);
    }
  };
  walk_until(1);
  is_counting_ = true;
  swap_ = {};
  longest_wait_ms_ = 0;
  epoch_before_ = phones_.front()->epoch;
  const auto counted = Clock::now();
  walk_until(1 + seconds);
  is_counting_ = false;
  Walked walked{.heard = {},
                .seconds = Seconds(Clock::now() - counted),
                .longest_wait_ms = longest_wait_ms_,
                .swap = swap_};
  for (const auto& phone : phones_) walked.heard.push_back(std::exchange(phone->heard, {}));
  return walked;
}

}  // namespace waymark::bench
