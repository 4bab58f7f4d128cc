// SPDX-License-Identifier: Apache-2.0
// What rooms and devices are told.
#include "session/wire/internal/server_bus_impl.h"
#include "session/wire/server_bus.h"

namespace waymark::session::wire {
namespace {

waymark_Presence KeyOf(const DeviceId& device) {
  waymark_Presence key{};
  SetId(key.device, device);
  return key;
}

waymark_AnchorState KeyOf(const AnchorId& anchor) { return AnchorKey(anchor, false); }

}  // namespace

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
Result<void> ServerBus::Send(const DeviceId& device, const AnchorState& own) {
  return impl_->WriteTo(device, &DeviceWriters::own_anchors, &GatewayWriters::own_anchors, own);
}
Result<void> ServerBus::Send(const DeviceId& device, const OwnerState& state) {
  return impl_->WriteTo(device, &DeviceWriters::own_states, &GatewayWriters::own_states, state);
}
Result<void> ServerBus::Withdraw(const DeviceId& device, const AnchorId& own) {
  dds::Writer* const writer =
      impl_->FindWriter(device, &DeviceWriters::own_anchors, &GatewayWriters::own_anchors);
  if (writer == nullptr) return NotOpen("device", device.text());
  const waymark_AnchorState key = KeyOf(own);
  return writer->Dispose(&key);
}
void ServerBus::Forget(const DeviceId& device, const AnchorId& own) {
  const waymark_AnchorState key = KeyOf(own);
  if (auto* const writer =
          impl_->FindWriter(device, &DeviceWriters::own_anchors, &GatewayWriters::own_anchors)) {
    writer->Forget(&key);
  }
}
void ServerBus::Forget(const DeviceId& device, const std::string& owner) {
  waymark_OwnerState key{};
  SetText(key.owner, owner);
  if (auto* const writer =
          impl_->FindWriter(device, &DeviceWriters::own_states, &GatewayWriters::own_states)) {
    writer->Forget(&key);
  }
}
Result<void> ServerBus::Send(const GatewayPongs& pongs) {
  // Its phones stand in rooms of the slice from which it reported of them, but for who has come
  // another way meanwhile.
  for (const ClockPong& pong : pongs.pongs) {
    const auto phone = impl_->phones.find(pong.device);
    if (phone == impl_->phones.end()) continue;
    return Write(impl_->SliceFor(phone->second).gateway_pongs, pongs);
  }
  return {};
}

}  // namespace waymark::session::wire
