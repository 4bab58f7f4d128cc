// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "tests/bench/session/peers/protocol.h"

namespace waymark::bench {
namespace {

constexpr std::uint8_t kConnect = 0x10, kPublish = 0x30, kSubscribe = 0x82;
constexpr std::uint8_t kVersion = 5, kCleanStart = 2, kNoLocal = 4;

void AppendText(const std::string& text, Bytes& bytes) {
  bytes.push_back(static_cast<std::uint8_t>(text.size() >> 8));
  bytes.push_back(static_cast<std::uint8_t>(text.size()));
  bytes.insert(bytes.end(), text.begin(), text.end());
}

void AppendPacket(std::uint8_t kind, const Bytes& body, Bytes& bytes) {
  bytes.push_back(kind);
  std::size_t rest = body.size();
  do {
    bytes.push_back(static_cast<std::uint8_t>((rest & 0x7f) | (rest > 0x7f ? 0x80 : 0)));
    rest >>= 7;
  } while (rest > 0);
  bytes.insert(bytes.end(), body.begin(), body.end());
}

std::string TopicOf(int room) { return fmt::format("room{}", room); }

class Mqtt final : public Protocol {
 public:
  Bytes Greeting(int phone, int room) const override {
    Bytes connect, subscribe{0, 1, 0}, bytes;  // packet 1, no properties
    AppendText("MQTT", connect);
    // Version, flags, no time to be heard of within, no properties.
    for (const int octet : {int{kVersion}, int{kCleanStart}, 0, 0, 0}) {
      connect.push_back(static_cast<std::uint8_t>(octet));
    }
    AppendText(fmt::format("phone{}", phone), connect);
    AppendText(TopicOf(room), subscribe);
    subscribe.push_back(kNoLocal);
    AppendPacket(kConnect, connect, bytes);
    AppendPacket(kSubscribe, subscribe, bytes);
    return bytes;
  }

  Bytes Publication(int room, std::span<const std::uint8_t> payload) const override {
    Bytes body, bytes;
    AppendText(TopicOf(room), body);
    body.push_back(0);  // no properties
    body.insert(body.end(), payload.begin(), payload.end());
    AppendPacket(kPublish, body, bytes);
    return bytes;
  }

  Packet FindPacket(std::span<const std::uint8_t> heard) const override {
    std::size_t size = 0, at = 1;
    for (int shift = 0;; shift += 7, ++at) {
      if (at >= heard.size()) return {};
      size |= static_cast<std::size_t>(heard[at] & 0x7f) << shift;
      if ((heard[at] & 0x80) == 0) break;
    }
    ++at;
    if (heard.size() < at + size) return {};
    Packet packet{.size = at + size};
    const auto body = heard.subspan(at, size);
    if ((heard[0] & 0xf0) != kPublish || size < 3) return packet;
    const std::size_t topic = static_cast<std::size_t>(body[0] << 8 | body[1]) + 2;
    if (topic < size) packet.payload = body.subspan(topic + 1 + body[topic]);
    return packet;
  }
};

}  // namespace

std::unique_ptr<Protocol> MakeMqtt() { return std::make_unique<Mqtt>(); }

}  // namespace waymark::bench
