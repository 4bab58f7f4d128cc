// SPDX-License-Identifier: Apache-2.0
#include "session/wire/device_bus.h"

#include "session/wire/internal/readers.h"

namespace waymark::session::wire {
namespace {

struct UpWriters {
  dds::Writer hello;
  dds::Writer poses;
  dds::Writer queries;
  dds::Writer commands;
  dds::Writer pings;
  dds::Writer room_commands;
  std::optional<dds::Writer> areas;  // of a device that asks for them
};

Result<UpWriters> MakeUpWriters(dds::Participant& participant, const RoomId& room,
                                const DeviceId& device, AnchorScope scope) {
  const std::string partition = UpPartition(room, device);
  WAYMARK_TRY_ASSIGN(auto hello, MakeWriter<Hello>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto poses, MakeWriter<PoseReport>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto queries, MakeWriter<LocaliseQuery>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto commands, MakeWriter<AnchorCommand>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto pings, MakeWriter<ClockPing>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto room_commands, MakeWriter<RoomCommand>(participant, partition));
  std::optional<dds::Writer> areas;
  if (scope == AnchorScope::kArea) {
    WAYMARK_TRY_ASSIGN(areas, MakeWriter<AreaReport>(participant, partition));
  }
  return UpWriters{std::move(hello),    std::move(poses), std::move(queries),
                   std::move(commands), std::move(pings), std::move(room_commands),
                   std::move(areas)};
}

/// What is said to others in its slice is not for it.
DeviceLink::Handler ForOwnEars(DeviceLink::Handler handler, const DeviceId& device) {
  return [handler = std::move(handler), device](DeviceLink::Event event) {
    if (const auto* message = std::get_if<Downward>(&event)) {
      const auto* const welcome = std::get_if<Welcome>(message);
      if (welcome != nullptr && welcome->device != device) return;
    }
    handler(std::move(event));
  };
}

}  // namespace

struct DeviceBus::Impl {
  UpWriters writers;
  DeviceId device;
  Readers readers;
};

DeviceBus::DeviceBus(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DeviceBus::~DeviceBus() = default;

Result<void> CheckIdentity(const RoomId& room, const DeviceId& device) {
  WAYMARK_TRY(CheckName(room.text(), "room"));
  if (FindUuid(device.text())) return {};
  return MakeError(ErrorCode::kInvalidArgument, "device id: expected a UUID, found \"{}\"",
                   device.text());
}

Result<std::unique_ptr<DeviceBus>> DeviceBus::Create(std::shared_ptr<dds::Participant> participant,
                                                     const RoomId& room, const DeviceId& device,
                                                     Handler handler, AnchorScope scope) {
  WAYMARK_TRY(CheckIdentity(room, device));
  WAYMARK_TRY_ASSIGN(UpWriters writers, MakeUpWriters(*participant, room, device, scope));
  std::unique_ptr<Impl> impl(new Impl{std::move(writers), device, Readers(std::move(participant))});
  Readers& readers = impl->readers;
  readers.CallWhenLost({.device = [handler](const DeviceId& lost) { handler(DeviceLost{lost}); },
                        .anchor =
                            [handler](const AnchorId& lost, bool is_own) {
                              handler(AnchorLost{lost, is_own});
                            }});
  WAYMARK_TRY(readers.ListenToOwn(DevicePartition(room, device), ForOwnEars(handler, device)));
  WAYMARK_TRY(readers.Listen<ClockPong>(DevicePartition(room, device), handler));
  WAYMARK_TRY(readers.Listen<PoseBatch>(DevicePartition(room, device), handler));
  WAYMARK_TRY(scope == AnchorScope::kRoom ? readers.ListenToAnchors(room, handler)
                                          : readers.ListenToArea(room, device, handler));
  WAYMARK_TRY(readers.ListenToRoom(room, handler));
  return std::unique_ptr<DeviceBus>(new DeviceBus(std::move(impl)));
}

Result<void> DeviceBus::Send(Upward message) {
  struct Sender {
    Impl& impl;

    Result<void> operator()(const Hello& m) { return Write(impl.writers.hello, m); }
    Result<void> operator()(const PoseReport& m) { return Write(impl.writers.poses, m); }
    Result<void> operator()(const LocaliseQuery& m) { return Write(impl.writers.queries, m); }
    Result<void> operator()(const AnchorCommand& m) { return Write(impl.writers.commands, m); }
    Result<void> operator()(const ClockPing& m) { return Write(impl.writers.pings, m); }
    Result<void> operator()(const RoomCommand& m) { return Write(impl.writers.room_commands, m); }
    Result<void> operator()(const AreaReport& m) {
      if (impl.writers.areas) return Write(*impl.writers.areas, m);
      return MakeError(ErrorCode::kUnsupported, "area: this device hears of the whole room");
    }
    Result<void> operator()(const Farewell& m) {
      waymark_Hello key{};
      SetId(key.device, m.device);
      return impl.writers.hello.Dispose(&key);
    }
  };
  return std::visit(Sender{*impl_}, message);
}

void DeviceBus::SayFarewell() {
  constexpr std::chrono::milliseconds kPatience{200};
  // Not heard is no harm: the server notices the silence.
  (void)Send(Farewell{impl_->device});
  (void)impl_->writers.hello.WaitForAcknowledgements(kPatience);
}

}  // namespace waymark::session::wire
