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

constexpr std::chrono::milliseconds kSlice{1};  // what is due in it is done together

}  // namespace

struct Crowd::Phone {
  WebSocket socket;
  std::uint32_t number;
  Walker walker;
  Hello hello;
  Ticket ticket{};
  std::uint32_t pings = 0;
  Heard heard = {};

  void Say(const wire::Upward& message) { (void)socket.Send(wire::EncodeFrame(message)); }

  void Report(std::uint32_t step) {
    Say(PoseReport{ticket, walker.PoseAt(Now())});
    if ((step + number) % kPingEvery == 0) Say(ClockPing{ticket, pings++, {}});
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
  if (is_counting_) phone.heard.bytes += message.size();
  const bool is_known = phone.ticket != Ticket{};
  const auto kind = message.empty() ? 0 : message[0];
  constexpr int kWelcome = 17, kPoses = 26;
  if (is_known ? !is_counting_ || kind != kPoses : kind != kWelcome) return;
  const auto decoded = wire::DecodeDownward(message);
  if (!decoded) return;
  if (const auto* welcome = std::get_if<Welcome>(&*decoded)) {
    if (welcome->verdict != JoinVerdict::kAccepted) {
      return LogWarning("{}: {}", phone.hello.name, welcome->reason);
    }
    phone.ticket = welcome->ticket;
    ++welcome_;
  } else if (const auto* batch = std::get_if<PoseBatch>(&*decoded)) {
    Count(phone.heard, *batch);
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
            static_cast<std::uint32_t>(reports / phones_.size()));
      }
      Listen();
      std::this_thread::sleep_for(kSlice);
    }
  };
  walk_until(1);
  is_counting_ = true;
  const auto counted = Clock::now();
  walk_until(1 + seconds);
  is_counting_ = false;
  Walked walked{.heard = {}, .seconds = Seconds(Clock::now() - counted)};
  for (const auto& phone : phones_) walked.heard.push_back(std::exchange(phone->heard, {}));
  return walked;
}

}  // namespace waymark::bench
