// SPDX-License-Identifier: Apache-2.0
// WebSockets as the gateway reads and writes them, against the examples of RFC 6455.
#include "session/socket/internal/web_socket_frames.h"

#include <gmock/gmock.h>

#include <numeric>

#include "session/socket/internal/upgrade.h"
#include "tests/session/client_frame.h"

namespace waymark::session::socket::internal {
namespace {

using Bytes = std::vector<std::uint8_t>;
using testing::ElementsAre;
using testing::HasSubstr;

Bytes Counting(std::size_t size) {
  Bytes bytes(size);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// What a reader makes of bytes that come so many at once.
struct Heard {
  std::vector<Bytes> messages, pings;
  Result<void> outcome;
};

Heard Hear(const Bytes& bytes, std::size_t at_once = SIZE_MAX, std::size_t limit = 1 << 20) {
  Heard heard;
  FrameReader reader(limit);
  for (std::size_t at = 0; at < bytes.size() && heard.outcome.ok();) {
    const std::size_t count = std::min(at_once, bytes.size() - at);
    Bytes piece(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                bytes.begin() + static_cast<std::ptrdiff_t>(at + count));
    heard.outcome = reader.Read(piece, [&](Opcode opcode, std::span<const std::uint8_t> payload) {
      auto& kind = opcode == Opcode::kBinary ? heard.messages : heard.pings;
      kind.emplace_back(payload.begin(), payload.end());
      return true;
    });
    at += count;
  }
  return heard;
}

TEST(WebSocketFrames, AServersAreAsTheStandardShowsThem) {
  Bytes bytes;
  AppendFrame(Opcode::kText, Bytes{'H', 'e', 'l', 'l', 'o'}, bytes);
  EXPECT_EQ(bytes, (Bytes{0x81, 0x05, 0x48, 0x65, 0x6c, 0x6c, 0x6f}));
  bytes.clear();
  AppendFrame(Opcode::kBinary, Counting(256), bytes);
  EXPECT_THAT(Bytes(bytes.begin(), bytes.begin() + 4), ElementsAre(0x82, 0x7e, 0x01, 0x00));
  bytes.clear();
  AppendFrame(Opcode::kBinary, Counting(65536), bytes);
  EXPECT_THAT(Bytes(bytes.begin(), bytes.begin() + 10),
              ElementsAre(0x82, 0x7f, 0, 0, 0, 0, 0, 1, 0, 0));
}

TEST(WebSocketFrames, AreReadHoweverTheyAreCut) {
  const std::vector<Bytes> said{Counting(0),   Counting(1),    Counting(125),   Counting(126),
                                Counting(300), Counting(4096), Counting(65535), Counting(70000)};
  Bytes bytes;
  for (const Bytes& message : said) bytes = bytes + MakeClientFrame(Opcode::kBinary, message);
  for (const std::size_t at_once : {std::size_t{1}, std::size_t{3}, std::size_t{1000}, SIZE_MAX}) {
    const Heard heard = Hear(bytes, at_once);
    EXPECT_TRUE(heard.outcome.ok());
    EXPECT_EQ(heard.messages, said) << at_once;
  }
}

TEST(WebSocketFrames, OfOneMessageArePutTogetherAndPingsMayComeBetween) {
  const Heard heard = Hear(MakeClientFrame(Opcode::kBinary, Bytes{1, 2}, false) +
                           MakeClientFrame(Opcode::kPing, Bytes{7}) +
                           MakeClientFrame(Opcode::kContinuation, Bytes{3}, false) +
                           MakeClientFrame(Opcode::kContinuation, Bytes{4, 5}) +
                           MakeClientFrame(Opcode::kBinary, Bytes{6}));
  EXPECT_TRUE(heard.outcome.ok());
  EXPECT_THAT(heard.messages, ElementsAre(Bytes{1, 2, 3, 4, 5}, Bytes{6}));
  EXPECT_THAT(heard.pings, ElementsAre(Bytes{7}));
}

TEST(WebSocketFrames, ThatNoClientSendsAreRefused) {
  Bytes unmasked, reserved = MakeClientFrame(Opcode::kBinary, {}), unknown = reserved;
  AppendFrame(Opcode::kBinary, Bytes{1}, unmasked);
  reserved[0] |= 0x40;
  unknown[0] = 0x83;
  const Bytes long_ping = MakeClientFrame(Opcode::kPing, Counting(126));
  const Bytes cut_ping = MakeClientFrame(Opcode::kPing, {}, false);
  const Bytes text = MakeClientFrame(Opcode::kText, {});
  const Bytes no_begin = MakeClientFrame(Opcode::kContinuation, Bytes{1});
  const Bytes no_end =
      MakeClientFrame(Opcode::kBinary, {}, false) + MakeClientFrame(Opcode::kBinary, Bytes{1});
  for (const Bytes& bytes :
       {unmasked, reserved, unknown, long_ping, cut_ping, text, no_begin, no_end}) {
    const Heard heard = Hear(bytes);
    ASSERT_FALSE(heard.outcome.ok());
    EXPECT_EQ(heard.outcome.error().code, ErrorCode::kCorrupt);
    EXPECT_TRUE(heard.messages.empty());
  }
}

TEST(WebSocketFrames, LongerThanAllowedAreRefusedByTheirHeads) {
  EXPECT_TRUE(Hear(MakeClientFrame(Opcode::kBinary, Counting(1000)), SIZE_MAX, 1000).outcome.ok());
  const Bytes longer = MakeClientFrame(Opcode::kBinary, Counting(1001));
  EXPECT_FALSE(Hear(Bytes(longer.begin(), longer.begin() + 8), SIZE_MAX, 1000).outcome.ok());
  const Bytes in_parts = MakeClientFrame(Opcode::kBinary, Counting(600), false) +
                         MakeClientFrame(Opcode::kContinuation, Counting(401));
  EXPECT_FALSE(Hear(in_parts, SIZE_MAX, 1000).outcome.ok());
  Bytes endless = MakeClientFrame(Opcode::kBinary, Counting(70000));
  endless[2] = 0xff;
  EXPECT_FALSE(Hear(endless).outcome.ok());
}

TEST(WebSocketFrames, NothingIsReadAfterTheHandlerHasHadEnough) {
  FrameReader reader(1000);
  Bytes bytes = MakeClientFrame(Opcode::kBinary, Bytes{1}) + Bytes{0xff, 0xff};
  int calls = 0;
  const auto outcome =
      reader.Read(bytes, [&](Opcode, std::span<const std::uint8_t>) { return ++calls > 1; });
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(calls, 1);
}

// ---- the handshake ----------------------------------------------------------------------------

const std::string kRequest =
    "GET /chat HTTP/1.1\r\nHost: server.example.com\r\nUpgrade: websocket\r\n"
    "Connection: keep-alive, Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    "Sec-WebSocket-Version: 13\r\n\r\n";

TEST(Upgrade, IsAnsweredAsTheStandardShows) {
  const auto upgrade = FindUpgrade(kRequest + "more");
  ASSERT_TRUE(upgrade);
  EXPECT_TRUE(upgrade->is_accepted);
  EXPECT_THAT(upgrade->answer,
              HasSubstr("\r\nSec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"));
  EXPECT_EQ(upgrade->request_bytes, kRequest.size());
}

TEST(Upgrade, WaitsForTheWholeRequest) {
  EXPECT_FALSE(FindUpgrade(""));
  EXPECT_FALSE(FindUpgrade(kRequest.substr(0, kRequest.size() - 1)));
}

TEST(Upgrade, OtherRequestsAreRefused) {
  const auto without = [](const std::string& line) {
    std::string request = kRequest;
    const std::size_t begin = request.find(line);
    return request.erase(begin, request.find("\r\n", begin) + 2 - begin);
  };
  for (const std::string& request :
       {without("Upgrade: websocket"), without("Sec-WebSocket-Key"),
        without("Sec-WebSocket-Version"), std::string("GET / HTTP/1.1\r\n\r\n"),
        std::string("\x16\x03\x01\r\n\r\n"), std::string(kMaxRequestBytes, 'x')}) {
    const auto upgrade = FindUpgrade(request);
    ASSERT_TRUE(upgrade) << request;
    EXPECT_FALSE(upgrade->is_accepted) << request;
    EXPECT_THAT(upgrade->answer, HasSubstr("400 Bad Request"));
  }
}

}  // namespace
}  // namespace waymark::session::socket::internal
