// SPDX-License-Identifier: Apache-2.0
#include "session/wire/room_ear.h"

#include <optional>

#include "session/wire/internal/topics.h"

namespace waymark::session::wire {

struct RoomEar::Impl {
  std::shared_ptr<dds::Participant> participant;
  std::atomic<std::uint64_t> rejected = 0;
  std::optional<dds::Reader> reader;  // last: its callbacks end before the rest goes
};

RoomEar::RoomEar(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RoomEar::~RoomEar() = default;

Result<std::unique_ptr<RoomEar>> RoomEar::Create(std::shared_ptr<dds::Participant> participant,
                                                 const RoomId& room, Handler handler) {
  WAYMARK_TRY(CheckName(room.text(), "room"));
  auto impl = std::make_unique<Impl>();
  impl->participant = std::move(participant);
  WAYMARK_TRY_ASSIGN(impl->reader, MakeReader<PoseBatch>(*impl->participant, DownPartition(room),
                                                         impl->rejected, std::move(handler)));
  return std::unique_ptr<RoomEar>(new RoomEar(std::move(impl)));
}

}  // namespace waymark::session::wire
