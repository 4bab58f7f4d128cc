// SPDX-License-Identifier: Apache-2.0
#include "session/wire/device_bus.h"

#include <vector>

#include "session/wire/internal/topics.h"

namespace waymark::session::wire {
namespace {

struct UpWriters {
  dds::Writer hello;
  dds::Writer poses;
  dds::Writer queries;
  dds::Writer commands;
  dds::Writer pings;
};

Result<UpWriters> MakeUpWriters(dds::Participant& participant, const RoomId& room) {
  const std::string partition = UpPartition(room);
  WAYMARK_TRY_ASSIGN(auto hello, MakeWriter<Hello>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto poses, MakeWriter<PoseReport>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto queries, MakeWriter<LocaliseQuery>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto commands, MakeWriter<AnchorCommand>(participant, partition));
  WAYMARK_TRY_ASSIGN(auto pings, MakeWriter<ClockPing>(participant, partition));
  return UpWriters{std::move(hello), std::move(poses), std::move(queries), std::move(commands),
                   std::move(pings)};
}

}  // namespace

struct DeviceBus::Impl {
  Impl(std::shared_ptr<dds::Participant> participant_in, UpWriters writers_in,
       const DeviceId& device_in)
      : participant(std::move(participant_in)), writers(std::move(writers_in)), device(device_in) {}

  std::shared_ptr<dds::Participant> participant;
  UpWriters writers;
  DeviceId device;
  std::atomic<std::uint64_t> rejected = 0;
  std::vector<dds::Reader> readers;  // last: their callbacks end before the rest goes

  template <typename Message>
  Result<void> Listen(const std::string& partition, const Handler& handler) {
    return Listen<Message>(partition, handler, [](dds::Arrival, const WireOf<Message>&) {});
  }

  template <typename Message, typename OnEnd>
  Result<void> Listen(const std::string& partition, const Handler& handler, OnEnd on_end) {
    WAYMARK_TRY_ASSIGN(
        dds::Reader reader,
        MakeReader<Message>(
            *participant, partition, rejected,
            [handler](Message message) { handler(Downward(std::move(message))); }, on_end));
    readers.push_back(std::move(reader));
    return {};
  }

  Result<void> ListenToRoom(const RoomId& room, const Handler& handler) {
    const std::string partition = DownPartition(room);
    // Lost, as opposed to disposed, means that the server is away: nobody left because of that.
    WAYMARK_TRY(Listen<Presence>(partition, handler,
                                 [handler](dds::Arrival arrival, const waymark_Presence& key) {
                                   if (arrival != dds::Arrival::kDisposed) return;
                                   handler(Downward(DeviceGone{GetId<DeviceId>(key.device)}));
                                 }));
    WAYMARK_TRY(Listen<AnchorState>(
        partition, handler, [handler](dds::Arrival arrival, const waymark_AnchorState& key) {
          if (arrival != dds::Arrival::kDisposed) return;
          handler(Downward(AnchorGone{GetId<AnchorId>(key.anchor)}));
        }));
    WAYMARK_TRY(Listen<RoomState>(partition, handler));
    return Listen<MapState>(partition, handler);
  }

  Result<void> ListenToOwn(const RoomId& room, const Handler& handler) {
    const std::string partition = DevicePartition(room, device);
    WAYMARK_TRY(Listen<Welcome>(partition, handler));
    WAYMARK_TRY(Listen<LocaliseAnswer>(partition, handler));
    WAYMARK_TRY(Listen<CommandReply>(partition, handler));
    return Listen<ClockPong>(partition, handler);
  }
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
                                                     Handler handler, Poses poses) {
  WAYMARK_TRY(CheckIdentity(room, device));
  WAYMARK_TRY_ASSIGN(UpWriters writers, MakeUpWriters(*participant, room));
  auto impl = std::make_unique<Impl>(std::move(participant), std::move(writers), device);
  WAYMARK_TRY(impl->ListenToOwn(room, handler));
  WAYMARK_TRY(impl->ListenToRoom(room, handler));
  if (poses == Poses::kHeard) WAYMARK_TRY(impl->Listen<PoseBatch>(DownPartition(room), handler));
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
