// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "tests/bench/session/peers/protocol.h"

namespace waymark::bench {
namespace {

constexpr std::uint8_t kConnect = 0x10, kPublish = 0x30, kSubscribe = 0x82, kUnsubscribe = 0xa2;
constexpr std::uint8_t kPublishAnswer = 0x40, kRetain = 1, kQos1 = 2;
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

std::string TopicOf(int topic) { return fmt::format("t{}", topic); }

class Mqtt final : public Protocol {
 public:
  Bytes Greeting(int phone) const override {
    Bytes connect, bytes;
    AppendText("MQTT", connect);
    // Version, flags, no time to be heard of within, no properties.
    for (const int octet : {int{kVersion}, int{kCleanStart}, 0, 0, 0}) {
      connect.push_back(static_cast<std::uint8_t>(octet));
    }
    AppendText(fmt::format("phone{}", phone), connect);
    AppendPacket(kConnect, connect, bytes);
    return bytes;
  }

  Bytes Subscribe(int topic) const override { return Subscription(TopicOf(topic), kNoLocal); }
  Bytes SubscribeToKept(int topic) const override {
    return Subscription(TopicOf(topic) + "/+", kNoLocal | 1);  // at QoS 1
  }

  Bytes Unsubscribe(int topic) const override {
    Bytes body{0, 1, 0}, bytes;  // packet 1, no properties
    AppendText(TopicOf(topic), body);
    AppendPacket(kUnsubscribe, body, bytes);
    return bytes;
  }

  Bytes Publish(int topic, std::span<const std::uint8_t> payload) const override {
    Bytes body, bytes;
    AppendText(TopicOf(topic), body);
    body.push_back(0);  // no properties
    body.insert(body.end(), payload.begin(), payload.end());
    AppendPacket(kPublish, body, bytes);
    return bytes;
  }

  Bytes Keep(int topic, int key, std::span<const std::uint8_t> payload) const override {
    Bytes body, bytes;
    AppendText(fmt::format("{}/{}", TopicOf(topic), key), body);
    const int packet = key % 0xffff + 1;
    for (const int octet : {packet >> 8, packet & 0xff, 0}) {  // no properties
      body.push_back(static_cast<std::uint8_t>(octet));
    }
    body.insert(body.end(), payload.begin(), payload.end());
    AppendPacket(kPublish | kRetain | kQos1, body, bytes);
    return bytes;
  }
  int AnswersToKeep() const override { return 1; }

  Packet FindPacket(std::span<const std::uint8_t> heard) const override {
    std::size_t size = 0, at = 1;
    for (int shift = 0;; shift += 7, ++at) {
      if (at >= heard.size()) return {};
      size |= static_cast<std::size_t>(heard[at] & 0x7f) << shift;
      if ((heard[at] & 0x80) == 0) break;
    }
    ++at;
    if (heard.size() < at + size) return {};
    Packet packet{.size = at + size, .is_answer = heard[0] == kPublishAnswer};
    const auto body = heard.subspan(at, size);
    if ((heard[0] & 0xf0) != kPublish || size < 3) return packet;
    const std::size_t number = (heard[0] & kQos1) != 0 ? 2 : 0;  // of a packet
    const std::size_t properties = static_cast<std::size_t>(body[0] << 8 | body[1]) + 2 + number;
    if (properties < size) packet.payload = body.subspan(properties + 1 + body[properties]);
    packet.kept = heard[0] & kRetain;
    if (number > 0) packet.number = body[properties - 2] << 8 | body[properties - 1];
    return packet;
  }

  Bytes Answer(const Packet& packet) const override {
    if (packet.number == 0) return {};
    return {kPublishAnswer, 2, static_cast<std::uint8_t>(packet.number >> 8),
            static_cast<std::uint8_t>(packet.number)};
  }

 private:
  static Bytes Subscription(const std::string& filter, int options) {
    Bytes body{0, 1, 0}, bytes;  // packet 1, no properties
    AppendText(filter, body);
    body.push_back(static_cast<std::uint8_t>(options));
    AppendPacket(kSubscribe, body, bytes);
    return bytes;
  }
};

}  // namespace

std::unique_ptr<Protocol> MakeMqtt() { return std::make_unique<Mqtt>(); }

}  // namespace waymark::bench
