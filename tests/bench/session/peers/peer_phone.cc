// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/peers/peer_phone.h"

#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <chrono>

namespace waymark::bench {

Result<PeerPhone> PeerPhone::Connect(std::uint16_t port, const Protocol& protocol, int phone) {
  WAYMARK_TRY_ASSIGN(ByteStream stream, ByteStream::Connect(port, false));
  PeerPhone connected(std::move(stream), protocol);
  connected.Send(protocol.Greeting(phone));
  WAYMARK_TRY(connected.Listen([](const auto&) { return true; }));
  return connected;
}

void PeerPhone::Send(const Bytes& bytes) const {
  (void)::send(stream_.descriptor(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

bool PeerPhone::HandlePackets(const OnPacket& on_packet) {
  std::span<const std::uint8_t> rest = waiting_;
  bool is_enough = false;
  while (!is_enough) {
    const auto packet = protocol_->FindPacket(rest);
    if (packet.size == 0) break;
    if (const Bytes answer = protocol_->Answer(packet); !answer.empty()) Send(answer);
    is_enough = on_packet(packet);
    rest = rest.subspan(packet.size);
  }
  waiting_.erase(waiting_.begin(), waiting_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  return is_enough;
}

Result<void> PeerPhone::Listen(const OnPacket& on_packet) {
  constexpr std::chrono::seconds kPatience{20};
  constexpr int kWait_ms = 200;
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  std::array<std::uint8_t, 64 * 1024> buffer;
  while (!HandlePackets(on_packet)) {
    if (std::chrono::steady_clock::now() > deadline) {
      return MakeError(ErrorCode::kTimeout, "a phone of a broker waits in vain");
    }
    pollfd ready{.fd = stream_.descriptor(), .events = POLLIN, .revents = 0};
    if (::poll(&ready, 1, kWait_ms) <= 0) continue;
    const ssize_t count = ::recv(stream_.descriptor(), buffer.data(), buffer.size(), 0);
    if (count <= 0) return MakeError(ErrorCode::kUnavailable, "a broker ended a connection");
    waiting_.insert(waiting_.end(), buffer.begin(), buffer.begin() + count);
  }
  return {};
}

}  // namespace waymark::bench
