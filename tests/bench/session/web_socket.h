// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "mapping/base/result.h"
#include "tests/bench/session/byte_stream.h"

namespace waymark::bench {

/// The client's end of a WebSocket with as little work as can be: so light that a thousand of them
/// in one thread leave the machine to what is measured. Thread-compatible.
class WebSocket {
 public:
  /// Connects to this machine and waits for the handshake. Errors: Unavailable.
  static Result<WebSocket> Connect(std::uint16_t port, bool is_tls);

  int descriptor() const { return stream_.descriptor(); }
  /// Sends a binary message; what the network does not take at once is dropped, as a whole.
  /// Says whether it was sent.
  bool Send(std::span<const std::uint8_t> message);
  /// Reads what is there and hands over each whole message. False: the connection is over.
  bool Receive(const std::function<void(std::span<const std::uint8_t>)>& on_message);

 private:
  explicit WebSocket(ByteStream stream) : stream_(std::move(stream)) {}

  ByteStream stream_;
  std::vector<std::uint8_t> outgoing_;
  std::vector<std::uint8_t> incoming_;  // of a message that is not whole yet
};

}  // namespace waymark::bench
