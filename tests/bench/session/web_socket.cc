// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/web_socket.h"

#include <array>
#include <string>
#include <string_view>
#include <utility>

namespace waymark::bench {
namespace {

constexpr std::uint8_t kBinary = 0x82;  // the whole message in one frame
constexpr std::uint8_t kPing = 0x89;
constexpr std::uint8_t kPong = 0x8a;
constexpr std::uint8_t kMasked = 0x80;
constexpr std::string_view kUpgrade =
    "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Protocol: waymark.1\r\n\r\n";

/// A client masks what it says; the key is its to choose, and zeros leave everything as it is.
void AppendFrame(std::vector<std::uint8_t>& bytes, std::uint8_t kind,
                 std::span<const std::uint8_t> message) {
  bytes.push_back(kind);
  if (message.size() < 126) {
    bytes.push_back(static_cast<std::uint8_t>(kMasked | message.size()));
  } else {
    bytes.push_back(kMasked | 126);
    bytes.push_back(static_cast<std::uint8_t>(message.size() >> 8));
    bytes.push_back(static_cast<std::uint8_t>(message.size()));
  }
  bytes.insert(bytes.end(), 4, 0);
  bytes.insert(bytes.end(), message.begin(), message.end());
}

struct Frame {
  std::uint8_t kind = 0;
  std::span<const std::uint8_t> message;
  std::size_t size = 0;  // with its head; 0: not whole
};

Frame FindFrame(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 2) return {};
  std::size_t head = 2;
  std::uint64_t length = bytes[1];
  if (length >= 126) {
    const std::size_t digits = length == 126 ? 2 : 8;
    if (bytes.size() < head + digits) return {};
    length = 0;
    for (std::size_t i = 0; i < digits; ++i) length = length << 8 | bytes[head + i];
    head += digits;
  }
  if (bytes.size() - head < length) return {};
  return {bytes[0], bytes.subspan(head, length), head + length};
}

}  // namespace

Result<WebSocket> WebSocket::Connect(std::uint16_t port, bool is_tls) {
  WAYMARK_TRY_ASSIGN(ByteStream stream, ByteStream::Connect(port, is_tls));
  const auto fail = [&](const char* what) {
    return MakeError(ErrorCode::kUnavailable, "127.0.0.1:{}: {} failed", port, what);
  };
  const auto* const upgrade = reinterpret_cast<const std::uint8_t*>(kUpgrade.data());
  if (!stream.Send({upgrade, kUpgrade.size()})) return fail("the handshake");
  std::string answer;
  while (!answer.ends_with("\r\n\r\n")) {
    std::uint8_t letter = 0;
    if (stream.Receive({&letter, 1}) != 1) return fail("the handshake");
    answer += static_cast<char>(letter);
  }
  if (!answer.starts_with("HTTP/1.1 101")) return fail("the upgrade");
  stream.SetNonBlocking();
  return WebSocket(std::move(stream));
}

bool WebSocket::Send(std::span<const std::uint8_t> message) {
  outgoing_.clear();
  AppendFrame(outgoing_, kBinary, message);
  return stream_.Send(outgoing_);
}

bool WebSocket::Receive(const std::function<void(std::span<const std::uint8_t>)>& on_message) {
  std::array<std::uint8_t, 64 * 1024> buffer;
  const ssize_t count = stream_.Receive(buffer);
  if (count <= 0) return count < 0;
  std::span<const std::uint8_t> bytes(buffer.data(), static_cast<std::size_t>(count));
  if (!incoming_.empty()) {
    incoming_.insert(incoming_.end(), bytes.begin(), bytes.end());
    bytes = incoming_;
  }
  while (true) {
    const Frame frame = FindFrame(bytes);
    if (frame.size == 0) break;
    if (frame.kind == kBinary) on_message(frame.message);
    if (frame.kind == kPing) {
      outgoing_.clear();
      AppendFrame(outgoing_, kPong, frame.message);
      (void)stream_.Send(outgoing_);
    }
    bytes = bytes.subspan(frame.size);
  }
  incoming_ = std::vector<std::uint8_t>(bytes.begin(), bytes.end());
  return true;
}

}  // namespace waymark::bench
