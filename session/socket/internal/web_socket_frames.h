// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mapping/base/result.h"

/// Frames of WebSockets as a server reads and writes them.
/// Source: RFC 6455, "The WebSocket Protocol", section 5
namespace waymark::session::socket::internal {

enum class Opcode : std::uint8_t {
  kContinuation = 0,
  kText = 1,
  kBinary = 2,
  kClose = 8,
  kPing = 9,
  kPong = 10
};

/// Appends a message in one frame; a server's is not masked.
void AppendFrame(Opcode opcode, std::span<const std::uint8_t> payload,
                 std::vector<std::uint8_t>& bytes);

/// Cuts what a client sends into messages. What is not whole yet waits, and takes no more memory
/// than has come of it. Thread-compatible.
class FrameReader {
 public:
  explicit FrameReader(std::size_t max_message_bytes) : max_message_bytes_(max_message_bytes) {}

  /// Takes a binary message, whatever number of frames it came in, or a control frame. False:
  /// nothing more shall be read.
  using Handler = std::function<bool(Opcode, std::span<const std::uint8_t>)>;

  /// Reads bytes as they came, unmasking them in place.
  /// Errors: Corrupt (no frame of a client, text, longer than allowed); read no more then.
  Result<void> Read(std::span<std::uint8_t> bytes, const Handler& handler);

 private:
  struct Head;

  Result<Head> ParseHead(std::span<const std::uint8_t> bytes) const;
  Result<bool> Take(const Head& head, std::span<const std::uint8_t> payload,
                    const Handler& handler);

  std::size_t max_message_bytes_;
  std::vector<std::uint8_t> waiting_;  // of a frame that is not whole
  std::vector<std::uint8_t> message_;  // of frames before the last one
  bool is_fragmented_ = false;
};

}  // namespace waymark::session::socket::internal
