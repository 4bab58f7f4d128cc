// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "session/wire/internal/topics.h"
#include "session/wire/server_bus.h"
#include "session/wire/slices.h"

namespace waymark::session::wire {

struct RoomWriters {
  dds::Writer presence;
  dds::Writer poses;
  dds::Writer anchors;
  dds::Writer state;
  dds::Writer map;
};

/// To the phones of gateways in a room: what is for one of them has its name as the key.
struct GatewayWriters {
  dds::Writer welcome;
  dds::Writer answers;
  dds::Writer replies;
  dds::Writer own_anchors;  // keyed by themselves: an anchor has one owner
  dds::Writer own_states;
  int devices = 0;  // that are open
};

/// To a device that asked for the anchors of an area.
struct AreaWriters {
  dds::Writer anchors;
  dds::Writer state;
};

struct DeviceWriters {
  dds::Writer welcome;
  dds::Writer answers;
  dds::Writer replies;
  dds::Writer own_anchors;
  dds::Writer own_states;
  dds::Writer pongs;
  dds::Writer poses;
  RoomId room;
  std::string partition;
  std::optional<AreaWriters> area = std::nullopt;  // once it has asked
};

/// Of the bus: who is on one hears nothing of the others.
struct Slice {
  dds::Participant participant;
  dds::Writer gateway_pongs;
  dds::Writer refusals;  // to whom came to another slice than its room's
};

/// How a device speaks to the server.
enum class Way { kItself, kByGateway };

/// What a message carries beyond its own size.
template <typename Wire>
std::size_t BytesOf(const Wire& wire) {
  if constexpr (requires { wire.image._length; }) return wire.image._length;
  if constexpr (requires { wire.payload._length; }) return wire.payload._length;
  return 0;
}

inline Error NotOpen(std::string_view what, const std::string& name) {
  return MakeError(ErrorCode::kNotFound, "{} {}: is not open on the bus", what, name);
}

struct ServerBus::Impl {
  explicit Impl(const ShareOptions& share) : shares(share) {}

  std::vector<Slice> slices;
  std::atomic<std::uint64_t> rejected = 0;
  Shares shares;
  std::map<RoomId, RoomWriters> rooms;
  std::map<DeviceId, DeviceWriters> devices;         // that speak for themselves
  std::map<DeviceId, RoomId> phones;                 // that a gateway speaks for
  std::map<RoomId, GatewayWriters> gateway_writers;  // for those
  std::mutex mutex;
  std::map<DeviceId, Way> ways;      // guarded by mutex; of the hellos that came last
  std::vector<dds::Reader> readers;  // last: their callbacks end before the rest goes

  /// To what devices say; each has its share.
  template <typename Message>
  Result<void> Listen(Slice& slice, const Handler& handler) {
    WAYMARK_TRY_ASSIGN(dds::Reader reader,
                       MakeReader<Message>(
                           slice.participant, TopicOf<Message>(), AnyUpPartition(), rejected,
                           [handler](Message message) { handler(Upward(std::move(message))); },
                           [](dds::Arrival, const WireOf<Message>&) {},
                           [this](const dds::Source& source, const WireOf<Message>& wire) {
                             return shares.Take(source.Partition(), BytesOf(wire),
                                                std::chrono::steady_clock::now());
                           }));
    readers.push_back(std::move(reader));
    return {};
  }

  Result<void> Open(const dds::ParticipantOptions& options);
  Result<void> Listen(std::size_t slice, const Handler& handler,
                      const GatewayHandler& gateway_handler);
  Result<void> ListenForHello(std::size_t slice, const Handler& handler);
  /// Only what comes from the device's own partition of its room, or from a gateway's, is the
  /// device's word.
  Result<Upward> HearHello(std::size_t slice, dds::Arrival arrival, const waymark_Hello& wire,
                           const dds::Source& source);
  /// Tells a device that its room is elsewhere, and says so.
  Error SendElsewhere(std::size_t slice, const Hello& hello);

  dds::Participant& ParticipantOf(const RoomId& room) { return SliceFor(room).participant; }
  Slice& SliceFor(const RoomId& room) {
    return slices[static_cast<std::size_t>(SliceOf(room, static_cast<int>(slices.size())))];
  }

  template <typename Message>
  Result<void> WriteTo(const RoomId& room, dds::Writer RoomWriters::*writer,
                       const Message& message) {
    const auto found = rooms.find(room);
    if (found == rooms.end()) return NotOpen("room", room.text());
    return Write(found->second.*writer, message);
  }

  template <typename Message>
  Result<void> WriteTo(dds::Writer DeviceWriters::*own, dds::Writer GatewayWriters::*shared,
                       const Message& message) {
    return WriteTo(message.device, own, shared, message);
  }
  template <typename Message>
  Result<void> WriteTo(const DeviceId& device, dds::Writer DeviceWriters::*own,
                       dds::Writer GatewayWriters::*shared, const Message& message) {
    dds::Writer* const writer = FindWriter(device, own, shared);
    if (writer == nullptr) return NotOpen("device", device.text());
    return Write(*writer, message);
  }
  dds::Writer* FindWriter(const DeviceId& device, dds::Writer DeviceWriters::*own,
                          dds::Writer GatewayWriters::*shared) {
    if (const auto phone = phones.find(device); phone != phones.end()) {
      return &(gateway_writers.at(phone->second).*shared);
    }
    const auto found = devices.find(device);
    return found == devices.end() ? nullptr : &(found->second.*own);
  }

  /// On DDS threads. A flood of names costs those their place that are not open yet; they ask
  /// again.
  void Remember(const DeviceId& device, Way way);
  std::optional<Way> FindWay(const DeviceId& device);

  /// Of a device that speaks for itself. Errors: NotFound, those of Writer::Create.
  Result<AreaWriters*> OpenArea(const DeviceId& device);
  AreaWriters* FindArea(const DeviceId& device) {
    const auto found = devices.find(device);
    return found == devices.end() || !found->second.area ? nullptr : &*found->second.area;
  }

  bool IsOpen(const DeviceId& device) const {
    return devices.contains(device) || phones.contains(device);
  }

  Result<void> OpenOwn(const RoomId& room, const DeviceId& device);
  Result<void> OpenByGateway(const RoomId& room, const DeviceId& device);
  void Close(const DeviceId& device);

  dds::Writer* FindWriter(const RoomId& room, dds::Writer RoomWriters::*writer) {
    const auto found = rooms.find(room);
    return found == rooms.end() ? nullptr : &(found->second.*writer);
  }
};

}  // namespace waymark::session::wire
