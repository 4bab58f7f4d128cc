// SPDX-License-Identifier: Apache-2.0
#include "session/wire/server_bus.h"

#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "session/wire/internal/topics.h"

namespace waymark::session::wire {
namespace {

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
  int devices = 0;  // that are open
};

struct DeviceWriters {
  dds::Writer welcome;
  dds::Writer answers;
  dds::Writer replies;
  dds::Writer pongs;
  dds::Writer poses;
};

waymark_Presence KeyOf(const DeviceId& device) {
  waymark_Presence key{};
  SetId(key.device, device);
  return key;
}

waymark_AnchorState KeyOf(const AnchorId& anchor) {
  waymark_AnchorState key{};
  SetId(key.anchor, anchor);
  return key;
}

template <typename Key>
void End(dds::Writer& writer, const DeviceId& device) {
  Key key{};
  SetId(key.device, device);
  (void)writer.Dispose(&key);
  writer.Forget(&key);
}

Error NotOpen(std::string_view what, const std::string& name) {
  return MakeError(ErrorCode::kNotFound, "{} {}: is not open on the bus", what, name);
}

/// How a device speaks to the server.
enum class Way { kItself, kByGateway };

}  // namespace

struct ServerBus::Impl {
  Impl(dds::Participant participant_in, dds::Writer gateway_pongs_in)
      : participant(std::move(participant_in)), gateway_pongs(std::move(gateway_pongs_in)) {}

  dds::Participant participant;
  dds::Writer gateway_pongs;
  std::atomic<std::uint64_t> rejected = 0;
  std::map<RoomId, RoomWriters> rooms;
  std::map<DeviceId, DeviceWriters> devices;         // that speak for themselves
  std::map<DeviceId, RoomId> phones;                 // that a gateway speaks for
  std::map<RoomId, GatewayWriters> gateway_writers;  // for those
  std::mutex mutex;
  std::map<DeviceId, Way> ways;      // guarded by mutex; of the hellos that came last
  std::vector<dds::Reader> readers;  // last: their callbacks end before the rest goes

  template <typename Message>
  Result<void> Listen(const Handler& handler) {
    return Listen<Message>(AnyUpPartition(),
                           [handler](Message message) { handler(Upward(std::move(message))); });
  }

  template <typename Message, typename OnMessage>
  Result<void> Listen(const std::string& partition, OnMessage on_message) {
    WAYMARK_TRY_ASSIGN(dds::Reader reader, MakeReader<Message>(participant, partition, rejected,
                                                               std::move(on_message)));
    readers.push_back(std::move(reader));
    return {};
  }

  /// Only what comes from the device's own partition of its room, or from a gateway's, is the
  /// device's word.
  Result<void> ListenForHello(const Handler& handler) {
    const dds::Topic topic = TopicOf<Hello>();
    WAYMARK_TRY_ASSIGN(
        dds::Reader reader,
        dds::Reader::Create(
            participant, topic, AnyUpPartition(),
            [this, handler](dds::Arrival arrival, const void* sample, const dds::Source& source) {
              const auto& wire = *static_cast<const waymark_Hello*>(sample);
              Result<Upward> word = HearHello(arrival, wire, source);
              if (word.ok()) return handler(*std::move(word));
              if (rejected++ == 0) LogWarning("hello: {}", ToString(word.error()));
            }));
    readers.push_back(std::move(reader));
    return {};
  }

  Result<Upward> HearHello(dds::Arrival arrival, const waymark_Hello& wire,
                           const dds::Source& source) {
    const auto device = GetId<DeviceId>(wire.device);
    if (arrival == dds::Arrival::kLost) return Upward(Farewell{device, true});
    const std::string partition = source.Partition();
    if (arrival == dds::Arrival::kDisposed) {
      const bool is_its_own =
          partition.ends_with(".up." + device.text()) || partition.ends_with(".up.gateway");
      if (is_its_own) return Upward(Farewell{device});
      return NotItsOwn(device);
    }
    WAYMARK_TRY_ASSIGN(Hello hello, Decode(wire));
    const bool is_by_gateway = partition == GatewayUpPartition(hello.room);
    if (!is_by_gateway && partition != UpPartition(hello.room, device)) return NotItsOwn(device);
    Remember(device, is_by_gateway ? Way::kByGateway : Way::kItself);
    return Upward(std::move(hello));
  }

  static Error NotItsOwn(const DeviceId& device) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "device {}: somebody else speaks for it, in another room or in its name",
                     device.text());
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
    if (const auto phone = phones.find(message.device); phone != phones.end()) {
      return Write(gateway_writers.at(phone->second).*shared, message);
    }
    const auto found = devices.find(message.device);
    if (found == devices.end()) return NotOpen("device", message.device.text());
    return Write(found->second.*own, message);
  }

  /// On DDS threads. A flood of names costs those their place that are not open yet; they ask
  /// again.
  void Remember(const DeviceId& device, Way way) {
    constexpr std::size_t kMaxWays = 16'384;
    const std::lock_guard lock(mutex);
    if (ways.size() >= kMaxWays) ways.clear();
    ways.insert_or_assign(device, way);
  }
  std::optional<Way> FindWay(const DeviceId& device) {
    const std::lock_guard lock(mutex);
    const auto found = ways.find(device);
    return found == ways.end() ? std::nullopt : std::optional(found->second);
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

ServerBus::ServerBus(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ServerBus::~ServerBus() = default;

Result<std::unique_ptr<ServerBus>> ServerBus::Create(const dds::ParticipantOptions& options,
                                                     Handler handler,
                                                     GatewayHandler gateway_handler) {
  WAYMARK_TRY_ASSIGN(dds::Participant participant, dds::Participant::Create(options));
  WAYMARK_TRY_ASSIGN(auto pongs, MakeWriter<GatewayPongs>(participant, kGatewaysDown));
  auto impl = std::make_unique<Impl>(std::move(participant), std::move(pongs));
  WAYMARK_TRY(impl->ListenForHello(handler));
  WAYMARK_TRY(impl->Listen<PoseReport>(handler));
  WAYMARK_TRY(impl->Listen<LocaliseQuery>(handler));
  WAYMARK_TRY(impl->Listen<AnchorCommand>(handler));
  WAYMARK_TRY(impl->Listen<ClockPing>(handler));
  WAYMARK_TRY(impl->Listen<GatewayReport>(kGatewaysUp, std::move(gateway_handler)));
  WAYMARK_TRY(impl->Listen<RoomCommand>(handler));
  return std::unique_ptr<ServerBus>(new ServerBus(std::move(impl)));
}

Result<void> ServerBus::OpenRoom(const RoomId& room) {
  if (impl_->rooms.contains(room)) return {};
  dds::Participant& participant = impl_->participant;
  const std::string partition = DownPartition(room);
  WAYMARK_TRY_ASSIGN(auto presence, MakeWriter<Presence>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto poses, MakeWriter<PoseBatch>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto anchors, MakeWriter<AnchorState>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto state, MakeWriter<RoomState>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto map, MakeWriter<MapState>(participant, partition));
  impl_->rooms.emplace(room, RoomWriters{std::move(presence), std::move(poses), std::move(anchors),
                                         std::move(state), std::move(map)});
  return {};
}

void ServerBus::CloseRoom(const RoomId& room) { impl_->rooms.erase(room); }

// The way may change while it is open: an app that was on the bus comes through a gateway.
Result<void> ServerBus::OpenDevice(const RoomId& room, const DeviceId& device) {
  impl_->Close(device);
  return impl_->FindWay(device) == Way::kByGateway ? impl_->OpenByGateway(room, device)
                                                   : impl_->OpenOwn(room, device);
}

Result<void> ServerBus::Impl::OpenOwn(const RoomId& room, const DeviceId& device) {
  const std::string partition = DevicePartition(room, device);
  WAYMARK_TRY_ASSIGN(auto welcome, MakeWriter<Welcome>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto answers, MakeWriter<LocaliseAnswer>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto replies, MakeWriter<CommandReply>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto pongs, MakeWriter<ClockPong>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto poses, MakeWriter<PoseBatch>(participant, partition));
  devices.insert_or_assign(device,
                           DeviceWriters{std::move(welcome), std::move(answers), std::move(replies),
                                         std::move(pongs), std::move(poses)});
  return {};
}

Result<void> ServerBus::Impl::OpenByGateway(const RoomId& room, const DeviceId& device) {
  auto found = gateway_writers.find(room);
  if (found == gateway_writers.end()) {
    const std::string partition = GatewayDownPartition(room);
    WAYMARK_TRY_ASSIGN(auto welcome, MakeWriter<Welcome>(participant, partition));
    WAYMARK_TRY_ASSIGN(auto answers, MakeWriter<LocaliseAnswer>(participant, partition));
    WAYMARK_TRY_ASSIGN(auto replies, MakeWriter<CommandReply>(participant, partition));
    found = gateway_writers
                .emplace(room,
                         GatewayWriters{std::move(welcome), std::move(answers), std::move(replies)})
                .first;
  }
  ++found->second.devices;
  phones.emplace(device, room);
  return {};
}

void ServerBus::Impl::Close(const DeviceId& device) {
  devices.erase(device);
  const auto phone = phones.find(device);
  if (phone == phones.end()) return;
  const auto shared = gateway_writers.find(phone->second);
  if (--shared->second.devices == 0) {
    gateway_writers.erase(shared);
  } else {  // lest the histories grow with everybody who was ever here
    End<waymark_Welcome>(shared->second.welcome, device);
    End<waymark_LocaliseAnswer>(shared->second.answers, device);
    End<waymark_CommandReply>(shared->second.replies, device);
  }
  phones.erase(phone);
}

void ServerBus::CloseDevice(const DeviceId& device) {
  impl_->Close(device);
  const std::lock_guard lock(impl_->mutex);
  impl_->ways.erase(device);
}
bool ServerBus::IsOpen(const DeviceId& device) const { return impl_->IsOpen(device); }
bool ServerBus::HasChangedItsWay(const DeviceId& device) const {
  const auto way = impl_->FindWay(device);
  return way && impl_->IsOpen(device) &&
         impl_->phones.contains(device) != (*way == Way::kByGateway);
}

Result<void> ServerBus::Publish(const RoomId& room, const Presence& presence) {
  return impl_->WriteTo(room, &RoomWriters::presence, presence);
}
Result<void> ServerBus::Publish(const RoomId& room, const PoseBatch& batch) {
  return impl_->WriteTo(room, &RoomWriters::poses, batch);
}
bool ServerBus::IsHeardByGateways(const RoomId& room) const {
  const auto found = impl_->rooms.find(room);
  return found != impl_->rooms.end() && found->second.poses.HasReaders();
}
Result<void> ServerBus::Publish(const RoomId& room, const AnchorState& state) {
  return impl_->WriteTo(room, &RoomWriters::anchors, state);
}
Result<void> ServerBus::Publish(const RoomId& room, const RoomState& state) {
  return impl_->WriteTo(room, &RoomWriters::state, state);
}

Result<void> ServerBus::Publish(const RoomId& room, const MapState& state) {
  return impl_->WriteTo(room, &RoomWriters::map, state);
}

Result<void> ServerBus::Withdraw(const RoomId& room, const DeviceId& device) {
  dds::Writer* const writer = impl_->FindWriter(room, &RoomWriters::presence);
  if (writer == nullptr) return NotOpen("room", room.text());
  const waymark_Presence key = KeyOf(device);
  return writer->Dispose(&key);
}
Result<void> ServerBus::Withdraw(const RoomId& room, const AnchorId& anchor) {
  dds::Writer* const writer = impl_->FindWriter(room, &RoomWriters::anchors);
  if (writer == nullptr) return NotOpen("room", room.text());
  const waymark_AnchorState key = KeyOf(anchor);
  return writer->Dispose(&key);
}

void ServerBus::Forget(const RoomId& room, const DeviceId& device) {
  const waymark_Presence key = KeyOf(device);
  if (auto* const writer = impl_->FindWriter(room, &RoomWriters::presence)) writer->Forget(&key);
}
void ServerBus::Forget(const RoomId& room, const AnchorId& anchor) {
  const waymark_AnchorState key = KeyOf(anchor);
  if (auto* const writer = impl_->FindWriter(room, &RoomWriters::anchors)) writer->Forget(&key);
}

Result<void> ServerBus::Send(const Welcome& welcome) {
  return impl_->WriteTo(&DeviceWriters::welcome, &GatewayWriters::welcome, welcome);
}
Result<void> ServerBus::Send(const LocaliseAnswer& answer) {
  return impl_->WriteTo(&DeviceWriters::answers, &GatewayWriters::answers, answer);
}
Result<void> ServerBus::Send(const CommandReply& reply) {
  return impl_->WriteTo(&DeviceWriters::replies, &GatewayWriters::replies, reply);
}
Result<void> ServerBus::Send(const ClockPong& pong) {
  const auto found = impl_->devices.find(pong.device);
  if (found == impl_->devices.end()) return NotOpen("device", pong.device.text());
  return Write(found->second.pongs, pong);
}
Result<void> ServerBus::Send(const DeviceId& device, const PoseBatch& batch) {
  const auto found = impl_->devices.find(device);
  if (found == impl_->devices.end()) return NotOpen("device", device.text());
  return Write(found->second.poses, batch);
}
bool ServerBus::HearsPoses(const DeviceId& device) const {
  const auto found = impl_->devices.find(device);
  return found != impl_->devices.end() && found->second.poses.HasReaders();
}
Result<void> ServerBus::Send(const GatewayPongs& pongs) {
  return Write(impl_->gateway_pongs, pongs);
}

std::uint64_t ServerBus::RejectedMessages() const { return impl_->rejected; }

}  // namespace waymark::session::wire
