// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "mapping/base/result.h"
#include "tests/bench/session/byte_stream.h"
#include "tests/bench/session/peers/protocol.h"

namespace waymark::bench {

/// One phone of a broker's, which waits for what it hears. Thread-compatible.
class PeerPhone {
 public:
  /// Errors: Unavailable (nobody answers).
  static Result<PeerPhone> Connect(std::uint16_t port, const Protocol& protocol, int phone);

  void Send(const Bytes& bytes) const;
  /// Hands over each packet until that says it was enough. Errors: Timeout (20 s), Unavailable (the
  /// connection ended).
  using OnPacket = std::function<bool(const Protocol::Packet&)>;
  Result<void> Listen(const OnPacket& on_packet);

 private:
  PeerPhone(ByteStream stream, const Protocol& protocol)
      : stream_(std::move(stream)), protocol_(&protocol) {}

  /// Handles what is whole; says whether it was enough.
  bool HandlePackets(const OnPacket& on_packet);

  ByteStream stream_;
  const Protocol* protocol_;
  Bytes waiting_;  // not handled yet
};

}  // namespace waymark::bench
