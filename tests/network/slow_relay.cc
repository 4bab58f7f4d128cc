// SPDX-License-Identifier: Apache-2.0
#include "tests/network/slow_relay.h"

#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "tests/support/loopback.h"

namespace waymark::network {
namespace {

using support::Loopback;

constexpr std::size_t kPieceBytes = 1448;       // of a full packet
constexpr std::size_t kMaxWaiting = 16 * 1024;  // as a TCP window would
constexpr milliseconds kRetransmission{200};    // the least that Linux waits

/// Small buffers, so that who sends feels the way and not the kernel's memory.
void Prepare(int socket) {
  const int small = 8 * 1024, yes = 1;
  ::setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &small, sizeof small);
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

}  // namespace

Result<std::unique_ptr<SlowRelay>> SlowRelay::Start(std::uint16_t to_port, const Profile& profile,
                                                    std::uint64_t seed) {
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  Prepare(listener);  // what it accepts inherits this
  sockaddr_in address = Loopback(0);
  socklen_t length = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  if (::bind(listener, generic, length) != 0 || ::listen(listener, 16) != 0 ||
      ::getsockname(listener, generic, &length) != 0) {
    ::close(listener);
    return MakeError(ErrorCode::kUnavailable, "relay: no port to be had");
  }
  std::unique_ptr<SlowRelay> relay(
      new SlowRelay(listener, ntohs(address.sin_port), to_port, profile, seed));
  relay->thread_ = std::thread([raw = relay.get()] { raw->Work(); });
  return relay;
}

SlowRelay::~SlowRelay() {
  is_stopping_ = true;
  thread_.join();
  for (const auto& connection : connections_) {
    ::close(connection->up.from);
    ::close(connection->up.to);
  }
  ::close(listener_);
}

void SlowRelay::SetProfile(const Profile& profile) {
  const std::lock_guard lock(mutex_);
  profile_ = profile;
  for (const auto& connection : connections_) {
    connection->up.link.SetOptions(profile.up);
    connection->down.link.SetOptions(profile.down);
  }
}

void SlowRelay::Cut(bool is_cut) {
  const std::lock_guard lock(mutex_);
  is_cut_ = is_cut;
}

void SlowRelay::Work() {
  while (!is_stopping_) {
    std::vector<pollfd> waiting{{listener_, POLLIN, 0}};
    timespec patience{0, 5'000'000};
    {
      const std::lock_guard lock(mutex_);
      const auto left = NextDue() - std::chrono::steady_clock::now();
      patience.tv_nsec = std::clamp<std::int64_t>(left.count(), 0, patience.tv_nsec);
      if (is_cut_) patience.tv_nsec = 5'000'000;
      for (const auto& connection : connections_) {
        for (const Way* way : {&connection->up, &connection->down}) {
          const bool is_open = !is_cut_ && way->waiting_bytes < kMaxWaiting;
          waiting.push_back({is_open ? way->from : -1, POLLIN, 0});
        }
      }
    }
    ::ppoll(waiting.data(), waiting.size(), &patience, nullptr);
    const std::lock_guard lock(mutex_);
    if (is_cut_) continue;
    const Instant now = std::chrono::steady_clock::now();
    std::size_t i = 1;
    std::erase_if(connections_, [&](const std::unique_ptr<Connection>& connection) {
      const bool up = waiting[i++].revents != 0, down = waiting[i++].revents != 0;
      if (Move(connection->up, up, now) && Move(connection->down, down, now)) return false;
      ::close(connection->up.from);
      ::close(connection->up.to);
      return true;
    });
    if (waiting.front().revents != 0) Accept();
  }
}

void SlowRelay::Accept() {
  const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (client < 0) return;
  const int server = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = Loopback(to_port_);
  Prepare(server);
  if (::connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    ::close(client);
    ::close(server);
    return;
  }
  ::fcntl(server, F_SETFL, O_NONBLOCK);
  const std::uint64_t seed = seed_ += 2;
  connections_.push_back(std::make_unique<Connection>(
      Connection{.up = {client, server, Link(profile_.up, seed)},
                 .down = {server, client, Link(profile_.down, seed + 1)}}));
}

/// False: the connection is over.
bool SlowRelay::Move(Way& way, bool is_readable, Instant now) {
  if (is_readable) {
    std::array<std::uint8_t, kPieceBytes> buffer;
    const auto bytes = ::read(way.from, buffer.data(), buffer.size());
    if (bytes == 0 || (bytes < 0 && errno != EAGAIN)) return false;
    if (bytes > 0) {
      const auto size = static_cast<std::size_t>(bytes);
      // Lost pieces come later; so do those that a queue had no room for.
      std::optional<Instant> due = way.link.Carry(size, now);
      for (Instant again = now; !due; due = way.link.Carry(size, again)) again += kRetransmission;
      if (!way.under_way.empty()) due = std::max(*due, way.under_way.back().due);
      way.under_way.push_back({*due, {buffer.begin(), buffer.begin() + bytes}});
      way.waiting_bytes += size;
    }
  }
  while (!way.under_way.empty() && way.under_way.front().due <= now) {
    Piece& piece = way.under_way.front();
    const auto written = ::send(way.to, piece.bytes.data() + piece.passed,
                                piece.bytes.size() - piece.passed, MSG_NOSIGNAL);
    if (written < 0 && errno != EAGAIN) return false;
    if (written <= 0) return true;
    piece.passed += static_cast<std::size_t>(written);
    way.waiting_bytes -= static_cast<std::size_t>(written);
    if (piece.passed < piece.bytes.size()) return true;
    way.under_way.pop_front();
  }
  return true;
}

Instant SlowRelay::NextDue() const {
  Instant next = Instant::max();
  for (const auto& connection : connections_) {
    for (const Way* way : {&connection->up, &connection->down}) {
      if (!way->under_way.empty()) next = std::min(next, way->under_way.front().due);
    }
  }
  return next;
}

}  // namespace waymark::network
