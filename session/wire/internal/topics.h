// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>

#include "mapping/base/log.h"
#include "session/dds/endpoint.h"
#include "session/wire/internal/codec.h"

/// Topics, partitions, and typed endpoints on them; idl/README.md says why each is as it is.
namespace waymark::session::wire {

template <typename Message>
dds::Topic TopicOf();
/// Anchors of a device's area, which it alone is told.
dds::Topic AreaAnchorTopic();

// One prefix per room, so that a permission can be given for a room.
// A device writes where no other may, so that where a Hello comes from says whose it is.
inline std::string UpPartition(const RoomId& room, const DeviceId& device) {
  return "room." + room.text() + ".up." + device.text();
}
/// Where a gateway speaks for all of its phones in a room.
inline std::string GatewayUpPartition(const RoomId& room) {
  return "room." + room.text() + ".up.gateway";
}
inline std::string AnyUpPartition() { return "room.*.up.*"; }
inline std::string DownPartition(const RoomId& room) { return "room." + room.text() + ".down"; }
inline std::string DevicePartition(const RoomId& room, const DeviceId& device) {
  return "room." + room.text() + ".device." + device.text();
}
/// Where each device of any room hears what is for its own ears, or passes it by.
inline std::string AnyDevicePartition() { return "room.*.device.*"; }
/// Where gateways hear what is said to one of their phones in a room.
inline std::string GatewayDownPartition(const RoomId& room) {
  return "room." + room.text() + ".device.gateway";
}
inline constexpr const char* kGatewaysUp = "gateways.up";
inline constexpr const char* kGatewaysDown = "gateways.down";

template <typename Message>
Result<dds::Writer> MakeWriter(dds::Participant& participant, const std::string& partition) {
  return dds::Writer::Create(participant, TopicOf<Message>(), partition);
}

template <typename Message>
Result<void> Write(dds::Writer& writer, const Message& message) {
  Scratch scratch;
  const auto wire = Encode(message, scratch);
  return writer.Write(&wire);
}

/// Admits whatever comes.
struct AnySource {
  template <typename Wire>
  bool operator()(const dds::Source&, const Wire&) const {
    return true;
  }
};

/// Hands decoded messages to `on_message` and ended instances to `on_end` (with how they ended and
/// the key in the generated type). What does not decode is counted and goes no further, and what
/// `admit` says no to is not even decoded.
template <typename Message, typename OnMessage, typename OnEnd, typename Admit = AnySource>
Result<dds::Reader> MakeReader(dds::Participant& participant, const dds::Topic& topic,
                               const std::string& partition, std::atomic<std::uint64_t>& rejected,
                               OnMessage on_message, OnEnd on_end, Admit admit = {}) {
  return dds::Reader::Create(
      participant, topic, partition,
      [&rejected, name = topic.name, on_message = std::move(on_message), on_end = std::move(on_end),
       admit = std::move(admit)](dds::Arrival arrival, const void* sample,
                                 const dds::Source& source) {
        const auto& wire = *static_cast<const WireOf<Message>*>(sample);
        if (arrival != dds::Arrival::kSample) return on_end(arrival, wire);
        if (!admit(source, wire)) return;
        Result<Message> message = Decode(wire);
        if (message.ok()) return on_message(*std::move(message));
        // One line for the first: a hostile peer must not fill the log.
        if (rejected++ == 0) LogWarning("{}: {}", name, ToString(message.error()));
      });
}

template <typename Message, typename OnMessage>
Result<dds::Reader> MakeReader(dds::Participant& participant, const std::string& partition,
                               std::atomic<std::uint64_t>& rejected, OnMessage on_message) {
  return MakeReader<Message>(participant, TopicOf<Message>(), partition, rejected,
                             std::move(on_message), [](dds::Arrival, const WireOf<Message>&) {});
}

}  // namespace waymark::session::wire
