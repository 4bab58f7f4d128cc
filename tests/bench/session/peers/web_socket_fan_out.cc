// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/peers/web_socket_fan_out.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "session/socket/channel.h"
#include "tests/bench/session/peers/protocol.h"

namespace waymark::bench {
namespace {

using session::socket::Channel;

enum class Verb : std::uint8_t { kPublish, kSubscribe, kUnsubscribe, kSubscribeToKept, kKeep };

constexpr std::size_t kHeadBytes = 9;  // verb, topic, key

struct Head {
  Verb verb{};
  std::uint32_t topic = 0, key = 0;
};

Head ReadHead(std::span<const std::uint8_t> frame) {
  Head head{.verb = static_cast<Verb>(frame[0])};
  std::memcpy(&head.topic, frame.data() + 1, sizeof head.topic);
  std::memcpy(&head.key, frame.data() + 5, sizeof head.key);
  return head;
}

class Client final : public Protocol {
 public:
  Bytes Greeting(int) const override {
    constexpr std::string_view kRequest =
        "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n";
    return Bytes(kRequest.begin(), kRequest.end());
  }

  Bytes Subscribe(int topic) const override { return Frame(Verb::kSubscribe, topic); }
  Bytes Unsubscribe(int topic) const override { return Frame(Verb::kUnsubscribe, topic); }
  Bytes Publish(int topic, std::span<const std::uint8_t> payload) const override {
    return Frame(Verb::kPublish, topic, 0, payload);
  }
  Bytes SubscribeToKept(int topic) const override { return Frame(Verb::kSubscribeToKept, topic); }
  Bytes Keep(int topic, int key, std::span<const std::uint8_t> payload) const override {
    return Frame(Verb::kKeep, topic, key, payload);
  }
  int AnswersToKeep() const override { return 0; }

  Packet FindPacket(std::span<const std::uint8_t> heard) const override {
    if (heard.size() < 2) return {};
    if (heard[0] == 'H') {  // the answer to the request
      const std::string_view text(reinterpret_cast<const char*>(heard.data()), heard.size());
      const std::size_t end = text.find("\r\n\r\n");
      return {.size = end == std::string_view::npos ? 0 : end + 4};
    }
    const std::size_t head = heard[1] == kTwoOctets ? 4 : 2;
    if (heard.size() < head) return {};
    const std::size_t length =
        head == 4 ? static_cast<std::size_t>(heard[2] << 8 | heard[3]) : heard[1];
    if (heard.size() < head + length) return {};
    const std::size_t size = head + length;
    if (heard[0] != 0x82 || length < kHeadBytes) return {.size = size};
    return {.size = size,
            .payload = heard.subspan(head + kHeadBytes, length - kHeadBytes),
            .kept = ReadHead(heard.subspan(head)).verb == Verb::kKeep ? 1 : 0};
  }

 private:
  static constexpr std::uint8_t kTwoOctets = 126;  // of length follow

  static Bytes Frame(Verb verb, int topic, int key = 0,
                     std::span<const std::uint8_t> payload = {}) {
    const std::size_t length = kHeadBytes + payload.size();  // less than 65,536
    Bytes bytes{0x82, static_cast<std::uint8_t>(0x80 | std::min<std::size_t>(length, kTwoOctets))};
    if (length >= kTwoOctets) {
      bytes.push_back(static_cast<std::uint8_t>(length >> 8));
      bytes.push_back(static_cast<std::uint8_t>(length));
    }
    bytes.insert(bytes.end(), 4, 0);  // masked with nothing
    bytes.push_back(static_cast<std::uint8_t>(verb));
    for (const int number : {topic, key}) {
      for (int shift = 0; shift < 32; shift += 8) {
        bytes.push_back(static_cast<std::uint8_t>(number >> shift));
      }
    }
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    return bytes;
  }
};

}  // namespace

std::unique_ptr<Protocol> MakeWebSocketFanOut() { return std::make_unique<Client>(); }

struct FanOut::Impl {
  using ChannelPtr = std::shared_ptr<Channel>;

  void Take(const ChannelPtr& channel) {
    channel->Start({.on_frame =
                        [this, weak = std::weak_ptr(channel)](std::span<const std::uint8_t> frame) {
                          if (const auto from = weak.lock()) Pass(from, frame);
                        },
                    .on_end = [](const Error&) {}});
    const std::lock_guard lock(mutex);
    open.push_back(channel);
  }

  struct Topic {
    std::vector<ChannelPtr> subscribers;
    std::map<std::uint32_t, session::wire::SharedFrame> kept;  // by key
  };

  void Pass(const ChannelPtr& from, std::span<const std::uint8_t> frame) {
    if (frame.size() < kHeadBytes) return;
    const Head head = ReadHead(frame);
    const std::lock_guard lock(mutex);
    Topic& topic = topics[head.topic];
    switch (head.verb) {
      case Verb::kSubscribeToKept:
        for (const auto& [key, kept] : topic.kept) from->Send(kept, std::nullopt);
        [[fallthrough]];
      case Verb::kSubscribe:
        topic.subscribers.push_back(from);
        return;
      case Verb::kUnsubscribe:
        std::erase(topic.subscribers, from);
        return;
      case Verb::kPublish:
      case Verb::kKeep:
        break;
    }
    const auto shared = session::wire::Share(Bytes(frame.begin(), frame.end()));
    if (head.verb == Verb::kKeep) topic.kept[head.key] = shared;
    for (const ChannelPtr& other : topic.subscribers) {
      if (other != from) other->Send(shared, std::nullopt);
    }
  }

  std::mutex mutex;
  std::vector<ChannelPtr> open;
  std::unordered_map<std::uint32_t, Topic> topics;
  session::socket::SocketLoop loop{2};
  std::unique_ptr<session::socket::Listener> listener;
};

FanOut::FanOut() : impl_(std::make_unique<Impl>()) {}

FanOut::~FanOut() {
  impl_->listener.reset();
  impl_->loop.Stop();
}

Result<std::uint16_t> FanOut::Listen() {
  WAYMARK_TRY_ASSIGN(impl_->listener,
                     session::socket::Listen(impl_->loop, {}, [this](auto channel) {
                       impl_->Take(std::move(channel));
                     }));
  return impl_->listener->port();
}

}  // namespace waymark::bench
