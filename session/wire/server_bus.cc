// SPDX-License-Identifier: Apache-2.0
#include "session/wire/server_bus.h"

#include <map>
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

struct DeviceWriters {
  dds::Writer welcome;
  dds::Writer answers;
  dds::Writer replies;
  dds::Writer pongs;
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

Error NotOpen(std::string_view what, const std::string& name) {
  return MakeError(ErrorCode::kNotFound, "{} {}: is not open on the bus", what, name);
}

}  // namespace

struct ServerBus::Impl {
  explicit Impl(dds::Participant participant_in) : participant(std::move(participant_in)) {}

  dds::Participant participant;
  std::atomic<std::uint64_t> rejected = 0;
  std::map<RoomId, RoomWriters> rooms;
  std::map<DeviceId, DeviceWriters> devices;
  std::vector<dds::Reader> readers;  // last: their callbacks end before the rest goes

  template <typename Message>
  Result<void> Listen(const Handler& handler) {
    WAYMARK_TRY_ASSIGN(
        dds::Reader reader,
        MakeReader<Message>(participant, AnyUpPartition(), rejected,
                            [handler](Message message) { handler(Upward(std::move(message))); }));
    readers.push_back(std::move(reader));
    return {};
  }

  Result<void> ListenForHello(const Handler& handler) {
    WAYMARK_TRY_ASSIGN(dds::Reader reader,
                       MakeReader<Hello>(
                           participant, AnyUpPartition(), rejected,
                           [handler](Hello hello) { handler(Upward(std::move(hello))); },
                           [handler](dds::Arrival, const waymark_Hello& key) {
                             handler(Upward(Farewell{GetId<DeviceId>(key.device)}));
                           }));
    readers.push_back(std::move(reader));
    return {};
  }

  template <typename Message>
  Result<void> WriteTo(const RoomId& room, dds::Writer RoomWriters::*writer,
                       const Message& message) {
    const auto found = rooms.find(room);
    if (found == rooms.end()) return NotOpen("room", room.text());
    return Write(found->second.*writer, message);
  }

  template <typename Message>
  Result<void> WriteTo(dds::Writer DeviceWriters::*writer, const Message& message) {
    const auto found = devices.find(message.device);
    if (found == devices.end()) return NotOpen("device", message.device.text());
    return Write(found->second.*writer, message);
  }

  dds::Writer* FindWriter(const RoomId& room, dds::Writer RoomWriters::*writer) {
    const auto found = rooms.find(room);
    return found == rooms.end() ? nullptr : &(found->second.*writer);
  }
};

ServerBus::ServerBus(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ServerBus::~ServerBus() = default;

Result<std::unique_ptr<ServerBus>> ServerBus::Create(const dds::ParticipantOptions& options,
                                                     Handler handler) {
  WAYMARK_TRY_ASSIGN(dds::Participant participant, dds::Participant::Create(options));
  auto impl = std::make_unique<Impl>(std::move(participant));
  WAYMARK_TRY(impl->ListenForHello(handler));
  WAYMARK_TRY(impl->Listen<PoseReport>(handler));
  WAYMARK_TRY(impl->Listen<LocaliseQuery>(handler));
  WAYMARK_TRY(impl->Listen<AnchorCommand>(handler));
  WAYMARK_TRY(impl->Listen<ClockPing>(handler));
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

Result<void> ServerBus::OpenDevice(const RoomId& room, const DeviceId& device) {
  dds::Participant& participant = impl_->participant;
  const std::string partition = DevicePartition(room, device);
  WAYMARK_TRY_ASSIGN(auto welcome, MakeWriter<Welcome>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto answers, MakeWriter<LocaliseAnswer>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto replies, MakeWriter<CommandReply>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto pongs, MakeWriter<ClockPong>(participant, partition));
  impl_->devices.insert_or_assign(device, DeviceWriters{std::move(welcome), std::move(answers),
                                                        std::move(replies), std::move(pongs)});
  return {};
}

void ServerBus::CloseDevice(const DeviceId& device) { impl_->devices.erase(device); }
bool ServerBus::IsOpen(const DeviceId& device) const { return impl_->devices.contains(device); }

Result<void> ServerBus::Publish(const RoomId& room, const Presence& presence) {
  return impl_->WriteTo(room, &RoomWriters::presence, presence);
}
Result<void> ServerBus::Publish(const RoomId& room, const PoseBatch& batch) {
  return impl_->WriteTo(room, &RoomWriters::poses, batch);
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
  return impl_->WriteTo(&DeviceWriters::welcome, welcome);
}
Result<void> ServerBus::Send(const LocaliseAnswer& answer) {
  return impl_->WriteTo(&DeviceWriters::answers, answer);
}
Result<void> ServerBus::Send(const CommandReply& reply) {
  return impl_->WriteTo(&DeviceWriters::replies, reply);
}
Result<void> ServerBus::Send(const ClockPong& pong) {
  return impl_->WriteTo(&DeviceWriters::pongs, pong);
}

std::uint64_t ServerBus::RejectedMessages() const { return impl_->rejected; }

}  // namespace waymark::session::wire
