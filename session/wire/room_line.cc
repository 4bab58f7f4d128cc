// SPDX-License-Identifier: Apache-2.0
#include "session/wire/room_line.h"

#include "session/wire/internal/readers.h"

namespace waymark::session::wire {
namespace {

waymark_Hello KeyOf(const DeviceId& device) {
  waymark_Hello key{};
  SetId(key.device, device);
  return key;
}

}  // namespace

struct RoomLine::Impl {
  std::shared_ptr<dds::Participant> participant;
  RoomId room;
  dds::Writer hello, queries, commands, room_commands;
  Readers readers;
};

RoomLine::RoomLine(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RoomLine::~RoomLine() = default;

Result<std::unique_ptr<RoomLine>> RoomLine::Create(std::shared_ptr<dds::Participant> participant,
                                                   const RoomId& room, Handler handler,
                                                   std::function<void()> on_lost) {
  WAYMARK_TRY(CheckName(room.text(), "room"));
  const std::string partition = GatewayUpPartition(room);
  WAYMARK_TRY_ASSIGN(auto hello, MakeWriter<Hello>(*participant, partition));
  WAYMARK_TRY_ASSIGN(auto queries, MakeWriter<LocaliseQuery>(*participant, partition));
  WAYMARK_TRY_ASSIGN(auto commands, MakeWriter<AnchorCommand>(*participant, partition));
  WAYMARK_TRY_ASSIGN(auto room_commands, MakeWriter<RoomCommand>(*participant, partition));
  std::unique_ptr<Impl> impl(new Impl{participant, room, std::move(hello), std::move(queries),
                                      std::move(commands), std::move(room_commands),
                                      Readers(participant)});
  WAYMARK_TRY(impl->readers.ListenToRoom(room, handler, on_lost));
  WAYMARK_TRY(impl->readers.ListenToAnchors(room, handler));
  WAYMARK_TRY(impl->readers.Listen<PoseBatch>(DownPartition(room), handler));
  WAYMARK_TRY(impl->readers.ListenToOwn(GatewayDownPartition(room), handler));
  return std::unique_ptr<RoomLine>(new RoomLine(std::move(impl)));
}

Result<void> RoomLine::Send(const Upward& message) {
  struct Sender {
    Impl& impl;

    Result<void> operator()(const Hello& m) { return Write(impl.hello, m); }
    Result<void> operator()(const LocaliseQuery& m) { return Write(impl.queries, m); }
    Result<void> operator()(const AnchorCommand& m) { return Write(impl.commands, m); }
    Result<void> operator()(const RoomCommand& m) { return Write(impl.room_commands, m); }
    Result<void> operator()(const Farewell& m) {
      const waymark_Hello key = KeyOf(m.device);
      return impl.hello.Dispose(&key);
    }
    Result<void> operator()(const PoseReport&) { return Refuse(); }
    Result<void> operator()(const ClockPing&) { return Refuse(); }
    Result<void> operator()(const AreaReport&) { return Refuse(); }

    Result<void> Refuse() const {
      return MakeError(ErrorCode::kUnsupported, "room {}: this goes another way", impl.room.text());
    }
  };
  return std::visit(Sender{*impl_}, message);
}

void RoomLine::Forget(const DeviceId& device) {
  const waymark_Hello key = KeyOf(device);
  impl_->hello.Forget(&key);
}

}  // namespace waymark::session::wire
