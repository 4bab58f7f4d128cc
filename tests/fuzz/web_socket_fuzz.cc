// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/check.h"
#include "session/socket/internal/upgrade.h"
#include "session/socket/internal/web_socket_frames.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/session/client_frame.h"

namespace waymark::fuzz {
namespace {

using namespace session::socket::internal;  // NOLINT: the whole file speaks its language

constexpr std::size_t kLimit = 1 << 16;

/// The messages in bytes that come so many at once, one after the other.
Bytes HeardOf(std::span<const std::uint8_t> bytes, std::size_t at_once) {
  FrameReader reader(kLimit);
  Bytes heard;
  for (std::size_t at = 0; at < bytes.size(); at += at_once) {
    const auto piece = bytes.subspan(at, std::min(at_once, bytes.size() - at));
    Bytes own(piece.begin(), piece.end());
    const auto outcome = reader.Read(own, [&](Opcode, std::span<const std::uint8_t> payload) {
      CHECK(payload.size() <= kLimit, "a message of {} octets", payload.size());
      heard.insert(heard.end(), payload.begin(), payload.end());
      return true;
    });
    if (!outcome.ok()) break;
  }
  return heard;
}

}  // namespace

std::vector<Bytes> Seeds() {
  const Bytes message(300, 0x5a);
  Bytes several = MakeClientFrame(Opcode::kBinary, message, false);
  for (const Bytes& frame :
       {MakeClientFrame(Opcode::kPing, Bytes(3)), MakeClientFrame(Opcode::kContinuation, message),
        MakeClientFrame(Opcode::kClose, Bytes{3, 232, 'b', 'y', 'e'})}) {
    several.insert(several.end(), frame.begin(), frame.end());
  }
  return {
      MakeClientFrame(Opcode::kBinary, Bytes(20)), several,
      MakeClientFrame(Opcode::kBinary, Bytes(kLimit)),
      ToBytes("GET / HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n")};
}

void TryOne(std::span<const std::uint8_t> bytes) {
  CHECK(HeardOf(bytes, 7) == HeardOf(bytes, std::max<std::size_t>(bytes.size(), 1)),
        "what is heard depends on how it is cut");
  (void)FindUpgrade(ToText(bytes));
}

}  // namespace waymark::fuzz
