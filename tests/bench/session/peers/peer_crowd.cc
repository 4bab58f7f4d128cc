// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/peers/peer_crowd.h"

#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <thread>

#include "session/wire/frames.h"
#include "tests/bench/session/byte_stream.h"
#include "tests/bench/session/walker.h"

namespace waymark::bench {

using namespace session;  // NOLINT: the whole file speaks its language
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::chrono::milliseconds kSlice{1};  // as Crowd
constexpr double kRoom_m = 5;
constexpr int kGroup = 4;  // of a city

Walker WalkerOf(const PeerCrowd::Options& options, int phone) {
  const bool is_city = options.city_m > 0;
  const int groups = (options.phones + kGroup - 1) / kGroup;
  const int group = is_city ? phone % groups : phone / options.per_room;
  return Walker(static_cast<std::uint64_t>(group),
                static_cast<std::uint64_t>(is_city ? phone / groups : phone),
                is_city ? options.city_m : kRoom_m);
}

}  // namespace

struct PeerCrowd::Phone {
  ByteStream stream;
  Ticket ticket;
  Walker walker;
  int topic = 0;  // that it publishes to
  std::optional<Cell> cell = {};
  Bytes waiting = {};  // of a packet that is not whole

  int descriptor() const { return stream.descriptor(); }
  void Send(const Bytes& bytes) const {
    (void)::send(descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
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
    crowd->phones_.push_back(std::make_unique<Phone>(
        Phone{std::move(stream), Ticket{static_cast<std::uint64_t>(i) + 1}, WalkerOf(options, i)}));
    Phone& phone = *crowd->phones_.back();
    phone.Send(protocol.Greeting(options.first_phone + i));
    char letter = 0;
    if (::recv(descriptor, &letter, 1, MSG_PEEK) != 1) {
      return MakeError(ErrorCode::kUnavailable, "127.0.0.1:{}: phone {} is not answered", port, i);
    }
    if (options.city_m > 0) {
      const auto position = phone.walker.PoseAt(Now()).map_from_device.translation();
      crowd->Enter(phone, Cell::At(position.x(), position.y()));
    } else {
      phone.topic = i / options.per_room;
      phone.Send(protocol.Subscribe(phone.topic));
    }
    phone.stream.SetNonBlocking();
    epoll_event event{.events = EPOLLIN, .data = {.ptr = &phone}};
    ::epoll_ctl(crowd->poll_, EPOLL_CTL_ADD, descriptor, &event);
  }
  return crowd;
}

/// Subscribes to the nine around it; what it heard before and is not among them it leaves.
void PeerCrowd::Enter(Phone& phone, const Cell& cell) {
  const auto before = phone.cell ? phone.cell->Around() : std::vector<Cell>();
  const auto now = cell.Around();
  const auto is_in = [](const std::vector<Cell>& cells, const Cell& one) {
    return std::ranges::find(cells, one) != cells.end();
  };
  for (const Cell& left : before) {
    if (!is_in(now, left)) phone.Send(protocol_.Unsubscribe(left.topic()));
  }
  for (const Cell& entered : now) {
    if (!is_in(before, entered)) phone.Send(protocol_.Subscribe(entered.topic()));
  }
  if (phone.cell) --in_cell_[*phone.cell];
  ++in_cell_[cell];
  if (is_counting_) ++heard_.moves;
  phone.cell = cell;
  phone.topic = cell.topic();
}

void PeerCrowd::Report(std::size_t i) {
  Phone& phone = *phones_[i];
  const LivePose pose = phone.walker.PoseAt(Now());
  int listeners = options_.per_room - 1;
  if (options_.city_m > 0) {
    const auto position = pose.map_from_device.translation();
    const Cell cell = Cell::At(position.x(), position.y());
    if (cell != phone.cell) Enter(phone, cell);
    listeners = -1;
    for (const Cell& near : cell.Around()) {
      if (const auto in = in_cell_.find(near); in != in_cell_.end()) listeners += in->second;
    }
  }
  if (is_counting_) heard_.due += static_cast<std::uint64_t>(listeners);
  phone.Send(protocol_.Publish(phone.topic,
                               wire::EncodeFrame(wire::Upward(PoseReport{phone.ticket, pose}))));
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
  if (is_counting_) heard_.bytes += bytes.size();
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
