// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/content_hash.h"
#include "session/recording/internal/layouts.h"
#include "session/recording/recording.h"

namespace waymark::session::recording {

using internal::Reader;
using internal::Writer;

std::uint64_t DigestEffects(std::span<const Effect> effects, TicketNames* tickets) {
  std::vector<std::uint8_t> bytes;
  Writer writer(bytes, tickets);
  for (const Effect& effect : effects) writer(effect);
  return Checksum(bytes);
}

std::string_view KindOf(const Event& event) {
  static constexpr std::array<std::string_view, std::variant_size_v<Event>> kNames{
      "HelloReceived",       "DeviceLeft",      "Heard",
      "PoseReceived",        "CommandReceived", "RoomLoaded",
      "WriteFinished",       "StoreChanged",    "Localised",
      "ReleaseSwapped",      "Ticked",          "PermitsRevoked",
      "RoomCommandReceived", "AreaReceived",    "RoomPartLoaded",
      "RulesFound",          "RulesKept"};
  return kNames[event.index()];
}

std::vector<std::uint8_t> EncodeHeader(const RecordingHeader& header) {
  std::vector<std::uint8_t> bytes;
  Writer(bytes, nullptr)(header);
  return bytes;
}

std::vector<std::uint8_t> EncodeEvent(const Event& event, ServerTime time, std::uint64_t digest,
                                      TicketNames* tickets) {
  std::vector<std::uint8_t> bytes;
  Writer(bytes, tickets)(time, digest, event);
  return bytes;
}

Result<RecordingHeader> DecodeHeader(std::span<const std::uint8_t> bytes) {
  RecordingHeader header;
  Reader reader(bytes);
  reader(header);
  if (!reader.IsComplete()) return MakeError(ErrorCode::kCorrupt, "recording: its head is damaged");
  WAYMARK_TRY(header.options.Validate());
  return header;
}

Result<RecordedEvent> DecodeEvent(std::span<const std::uint8_t> bytes) {
  RecordedEvent recorded{.time = {}, .event = event::Ticked{}, .effects_digest = 0};
  Reader reader(bytes);
  reader(recorded.time, recorded.effects_digest, recorded.event);
  if (reader.IsComplete()) return recorded;
  return MakeError(ErrorCode::kCorrupt, "{} bytes are no event", bytes.size());
}

}  // namespace waymark::session::recording
