// SPDX-License-Identifier: Apache-2.0
// What devices are told that asked for the anchors of an area.
#include "session/wire/internal/server_bus_impl.h"
#include "session/wire/server_bus.h"

namespace waymark::session::wire {

Result<AreaWriters*> ServerBus::Impl::OpenArea(const DeviceId& device) {
  const auto found = devices.find(device);
  if (found == devices.end()) return NotOpen("device", device.text());
  DeviceWriters& writers = found->second;
  if (!writers.area) {
    dds::Participant& participant = ParticipantOf(writers.room);
    WAYMARK_TRY_ASSIGN(auto anchors,
                       dds::Writer::Create(participant, AreaAnchorTopic(), writers.partition));
    WAYMARK_TRY_ASSIGN(auto state, MakeWriter<AreaState>(participant, writers.partition));
    writers.area.emplace(AreaWriters{std::move(anchors), std::move(state)});
  }
  return &*writers.area;
}

Result<void> ServerBus::SendInArea(const DeviceId& device, const AnchorState& state) {
  WAYMARK_TRY_ASSIGN(AreaWriters* const writers, impl_->OpenArea(device));
  return Write(writers->anchors, state);
}

Result<void> ServerBus::SendInArea(const DeviceId& device, const AreaState& state) {
  WAYMARK_TRY_ASSIGN(AreaWriters* const writers, impl_->OpenArea(device));
  return Write(writers->state, state);
}

void ServerBus::WithdrawInArea(const DeviceId& device, const AnchorId& anchor) {
  AreaWriters* const writers = impl_->FindArea(device);
  const waymark_AnchorState key = AnchorKey(anchor, false);
  if (writers != nullptr) (void)writers->anchors.Dispose(&key);
}

void ServerBus::ForgetInArea(const DeviceId& device, const AnchorId& anchor) {
  AreaWriters* const writers = impl_->FindArea(device);
  const waymark_AnchorState key = AnchorKey(anchor, false);
  if (writers != nullptr) writers->anchors.Forget(&key);
}

void ServerBus::ForgetArea(const DeviceId& device) {
  const auto found = impl_->devices.find(device);
  if (found != impl_->devices.end()) found->second.area.reset();
}

}  // namespace waymark::session::wire
