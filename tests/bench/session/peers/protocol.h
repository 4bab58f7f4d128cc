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
/// what is measured. Topics are numbers; of each there is what passes and, apart from it, what is
/// kept under keys for those who come later.
class Protocol {
 public:
  virtual ~Protocol() = default;

  /// Who it is. Something is answered.
  virtual Bytes Greeting(int phone) const = 0;
  virtual Bytes Subscribe(int topic) const = 0;
  virtual Bytes Unsubscribe(int topic) const = 0;
  virtual Bytes Publish(int topic, std::span<const std::uint8_t> payload) const = 0;

  /// To what is kept under a topic, which is told at once, and to what is from now on.
  virtual Bytes SubscribeToKept(int topic) const = 0;
  virtual Bytes Keep(int topic, int key, std::span<const std::uint8_t> payload) const = 0;
  /// Answers to each Keep that say that it is done; 0: nothing is answered.
  virtual int AnswersToKeep() const = 0;

  struct Packet {
    std::size_t size = 0;                     ///< 0: not whole yet
    std::span<const std::uint8_t> payload{};  ///< of a publication, or nothing
    int kept = 0;                             ///< so many that were kept are in it
    bool is_answer = false;                   ///< to a Keep or, with Redis, to a Publish
    int number = 0;                           ///< of a publication that waits for an answer
  };
  /// The first packet of what was heard.
  virtual Packet FindPacket(std::span<const std::uint8_t> heard) const = 0;
  /// To a packet with a number; empty: none is wanted.
  virtual Bytes Answer(const Packet&) const { return {}; }
};

/// MQTT 5 at QoS 0, without a client's own publications; what is kept is retained, at QoS 1.
/// Source: OASIS, "MQTT Version 5.0", 2019
std::unique_ptr<Protocol> MakeMqtt();
/// RESP3, in which one connection publishes and subscribes; Redis returns a client's own. What is
/// kept is a hash for each topic, read once by those who subscribe.
std::unique_ptr<Protocol> MakeRedis();
/// Binary WebSocket messages: an octet that says what to do, the topic, the key of what is kept,
/// and what is passed on or kept.
std::unique_ptr<Protocol> MakeWebSocketFanOut();

}  // namespace waymark::bench
