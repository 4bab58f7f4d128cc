// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/peers/peer_crowd.h"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <thread>

#include "session/wire/frames.h"
#include "tests/bench/session/byte_stream.h"
#include "tests/bench/session/walker.h"

namespace waymark::bench {

using namespace session;  // NOLINT: the whole file speaks its language
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::chrono::milliseconds kSlice{1};  // as Crowd
constexpr double kEdge_m = 5;

}  // namespace

struct PeerCrowd::Phone {
  ByteStream stream;
  int room;
  Ticket ticket;
  Walker walker;
  Bytes waiting = {};  // of a packet that is not whole

  int descriptor() const { return stream.descriptor(); }
};

PeerCrowd::PeerCrowd(const Protocol& protocol, const Options& options)
    : protocol_(protocol), options_(options), poll_(::epoll_create1(EPOLL_CLOEXEC)) {}

PeerCrowd::~PeerCrowd() { ::close(poll_); }

Result<std::unique_ptr<PeerCrowd>> PeerCrowd::Connect(std::uint16_t port, const Protocol& protocol,
                                                      const Options& options) {
  std::unique_ptr<PeerCrowd> crowd(new PeerCrowd(protocol, options));
  for (int i = 0; i < options.phones; ++i) {
    WAYMARK_TRY_ASSIGN(ByteStream stream, ByteStream::Connect(port, false));
    const int descriptor = stream.descriptor();
    const auto number = static_cast<std::uint64_t>(i);
    const int room = i / options.per_room;
    crowd->phones_.push_back(
        std::make_unique<Phone>(Phone{std::move(stream), room, Ticket{number + 1},
                                      Walker(static_cast<std::uint64_t>(room), number, kEdge_m)}));
    const Bytes greeting = protocol.Greeting(i, room);
    (void)::send(descriptor, greeting.data(), greeting.size(), MSG_NOSIGNAL);
    char letter = 0;
    if (::recv(descriptor, &letter, 1, MSG_PEEK) != 1) {
      return MakeError(ErrorCode::kUnavailable, "127.0.0.1:{}: phone {} is not answered", port, i);
    }
    crowd->phones_.back()->stream.SetNonBlocking();
    epoll_event event{.events = EPOLLIN, .data = {.ptr = crowd->phones_.back().get()}};
    ::epoll_ctl(crowd->poll_, EPOLL_CTL_ADD, descriptor, &event);
  }
  return crowd;
}

void PeerCrowd::Report(std::size_t i) {
  const Phone& phone = *phones_[i];
  const auto payload =
      wire::EncodeFrame(wire::Upward(PoseReport{phone.ticket, phone.walker.PoseAt(Now())}));
  const Bytes packet = protocol_.Publication(phone.room, payload);
  (void)::send(phone.descriptor(), packet.data(), packet.size(), MSG_NOSIGNAL);
}

void PeerCrowd::Listen() {
  std::array<epoll_event, 256> events;
  const int count = ::epoll_wait(poll_, events.data(), events.size(), 0);
  for (int i = 0; i < count; ++i) {
    auto& phone = *static_cast<Phone*>(events[static_cast<std::size_t>(i)].data.ptr);
    if (Receive(phone)) continue;
    ++lost_;
    ::epoll_ctl(poll_, EPOLL_CTL_DEL, phone.descriptor(), nullptr);
  }
}

bool PeerCrowd::Receive(Phone& phone) {
  std::array<std::uint8_t, 64 * 1024> buffer;
  const ssize_t count = ::recv(phone.descriptor(), buffer.data(), buffer.size(), 0);
  if (count <= 0) return count < 0 && (errno == EAGAIN || errno == EINTR);
  std::span<const std::uint8_t> bytes(buffer.data(), static_cast<std::size_t>(count));
  if (!phone.waiting.empty()) {
    phone.waiting.insert(phone.waiting.end(), bytes.begin(), bytes.end());
    bytes = phone.waiting;
  }
  while (true) {
    const auto packet = protocol_.FindPacket(bytes);
    if (packet.size == 0) break;
    if (is_counting_ && !packet.payload.empty()) Count(phone, packet.payload);
    bytes = bytes.subspan(packet.size);
  }
  phone.waiting = Bytes(bytes.begin(), bytes.end());
  return true;
}

void PeerCrowd::Count(const Phone& phone, std::span<const std::uint8_t> payload) {
  const auto message = wire::DecodeUpward(payload);
  if (!message.ok()) return;
  const auto* const report = std::get_if<PoseReport>(&*message);
  if (report == nullptr || report->ticket == phone.ticket) return;
  if (++heard_.poses % 8 != 1) return;
  heard_.ages_ms.push_back(static_cast<float>(1e3 * Seconds(Now() - report->pose.time)));
}

PeerCrowd::Heard PeerCrowd::Walk(double seconds) {
  const auto begin = Clock::now();
  const double reports_per_s = options_.hz * static_cast<double>(phones_.size());
  std::uint64_t reports = 0;
  const auto walk_until = [&](double end_s) {
    double now_s = Seconds(Clock::now() - begin);
    for (; now_s < end_s; now_s = Seconds(Clock::now() - begin)) {
      const auto due = static_cast<std::uint64_t>(now_s * reports_per_s);
      for (; reports < due; ++reports) Report(reports % phones_.size());
      Listen();
      std::this_thread::sleep_for(kSlice);
    }
  };
  walk_until(1);
  is_counting_ = true;
  const auto counted = Clock::now();
  walk_until(1 + seconds);
  is_counting_ = false;
  heard_.seconds = Seconds(Clock::now() - counted);
  return std::move(heard_);
}

}  // namespace waymark::bench
