// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/check.h"
#include "session/recording/recording.h"
#include "tests/fuzz/fuzz_target.h"

namespace waymark::fuzz {

namespace recording = session::recording;
namespace event = session::event;

std::vector<Bytes> Seeds() {
  const ServerTime now(std::chrono::seconds(1));
  std::vector<Bytes> seeds{recording::EncodeHeader({.run = session::RunId{7}})};
  const content::AnchorRecord record{.id = AnchorId("a"), .room = RoomId("square"), .kind = "note"};
  for (const session::Event& one :
       {session::Event(event::Ticked{}),
        session::Event(event::HelloReceived{
            {.device = DeviceId("d"), .room = RoomId("square"), .name = "n"}, session::Ticket{1}}),
        session::Event(event::PoseReceived{}),
        session::Event(
            event::RoomLoaded{RoomId("square"), std::uint64_t{3}, {session::RoomAnchor{record}}}),
        session::Event(event::StoreChanged{{{4, AnchorId("a"), RoomId("square"), record}}}),
        session::Event(event::ReleaseSwapped{2, std::make_shared<const session::Placements>(
                                                    session::Placements{{SubmapId("s"), {}}})}),
        session::Event(event::PermitsRevoked{{"t"}, {DeviceId("d")}}),
        session::Event(event::RoomCommandReceived{}),
        session::Event(event::RulesFound{{.capacities = {{RoomId("square"), 3}},
        .bans = {{{RoomId("square"), DeviceId("d")}, {now, "t", "spam"}}}}})}) {
    seeds.push_back(recording::EncodeEvent(one, now, 9));
  }
  return seeds;
}

void TryOne(std::span<const std::uint8_t> bytes) {
  (void)recording::DecodeHeader(bytes);
  (void)recording::RecordingReader::FromBytes({bytes.begin(), bytes.end()});
  const auto decoded = recording::DecodeEvent(bytes);
  if (!decoded) return;
  // To the bit, but for maps and sets, whose order and doubles are not kept.
  const Bytes again =
      recording::EncodeEvent(decoded->event, decoded->time, decoded->effects_digest);
  CHECK(recording::DecodeEvent(again).ok(), "what was read cannot be written");
}

}  // namespace waymark::fuzz
