// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/session/peers/web_socket_fan_out.h"

#include <cstring>
#include <map>
#include <mutex>
#include <string_view>

#include "session/socket/channel.h"
#include "tests/bench/session/peers/protocol.h"

namespace waymark::bench {
namespace {

using session::socket::Channel;

constexpr std::size_t kRoomBytes = 4;

class Client final : public Protocol {
 public:
  Bytes Greeting(int, int) const override {
    constexpr std::string_view kRequest =
        "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n";
    return Bytes(kRequest.begin(), kRequest.end());
  }

  Bytes Publication(int room, std::span<const std::uint8_t> payload) const override {
    const std::size_t size = kRoomBytes + payload.size();  // less than 126
    Bytes bytes{0x82, static_cast<std::uint8_t>(0x80 | size), 0, 0, 0, 0};
    for (std::size_t i = 0; i < kRoomBytes; ++i) {
      bytes.push_back(static_cast<std::uint8_t>(room >> (8 * i)));
    }
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    return bytes;
  }

  Packet FindPacket(std::span<const std::uint8_t> heard) const override {
    if (heard.size() < 2) return {};
    if (heard[0] == 'H') {  // the answer to the request
      const std::string_view text(reinterpret_cast<const char*>(heard.data()), heard.size());
      const std::size_t end = text.find("\r\n\r\n");
      return {.size = end == std::string_view::npos ? 0 : end + 4};
    }
    const std::size_t size = 2 + heard[1];
    if (heard.size() < size) return {};
    if (heard[0] != 0x82) return {.size = size};
    return {.size = size, .payload = heard.subspan(2 + kRoomBytes, heard[1] - kRoomBytes)};
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

  void Pass(const ChannelPtr& from, std::span<const std::uint8_t> frame) {
    if (frame.size() < kRoomBytes) return;
    std::uint32_t number = 0;
    std::memcpy(&number, frame.data(), sizeof number);
    const auto shared = session::wire::Share(Bytes(frame.begin(), frame.end()));
    const std::lock_guard lock(mutex);
    std::vector<ChannelPtr>& room = rooms[number];
    bool is_known = false;
    for (const ChannelPtr& other : room) {
      is_known |= other == from;
      if (other != from) other->Send(shared, std::nullopt);
    }
    if (!is_known) room.push_back(from);
  }

  std::mutex mutex;
  std::vector<ChannelPtr> open;
  std::map<std::uint32_t, std::vector<ChannelPtr>> rooms;
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
