// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace waymark::bench {

using Bytes = std::vector<std::uint8_t>;

/// What a phone says to a broker and hears from it, as octets: so little work that the broker is
/// what is measured.
class Protocol {
 public:
  virtual ~Protocol() = default;

  /// Who it is, and that it wants to hear its room. Something is answered.
  virtual Bytes Greeting(int phone, int room) const = 0;
  virtual Bytes Publication(int room, std::span<const std::uint8_t> payload) const = 0;

  struct Packet {
    std::size_t size = 0;                     ///< 0: not whole yet
    std::span<const std::uint8_t> payload{};  ///< of a publication, or nothing
  };
  /// The first packet of what was heard.
  virtual Packet FindPacket(std::span<const std::uint8_t> heard) const = 0;
};

/// MQTT 5 at QoS 0, without a client's own publications. Source: OASIS, "MQTT Version 5.0", 2019
std::unique_ptr<Protocol> MakeMqtt();
/// RESP3, in which one connection publishes and subscribes; Redis returns a client's own.
std::unique_ptr<Protocol> MakeRedis();
/// Binary WebSocket messages; the first four octets of each are its room.
std::unique_ptr<Protocol> MakeWebSocketFanOut();

}  // namespace waymark::bench
