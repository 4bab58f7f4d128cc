// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "session/recording/ticket_names.h"
#include "session/state/session_state.h"

/// A session as everything that entered its rules. README.md has the format byte by byte.
namespace waymark::session::recording {

inline constexpr std::uint32_t kFormatVersion = 6;

/// What a SessionState begins with.
struct RecordingHeader {
  StateOptions options = {};
  RunId run{};
  MapIdentity map = {};
  std::shared_ptr<const Placements> placements = nullptr;
  std::int64_t started_utc_ms = 0;
};

/// One step of the session.
struct RecordedEvent {
  ServerTime time;
  Event event;
  std::uint64_t effects_digest = 0;  ///< of all that the state wanted done
};

/// XXH3-64 of the effects' bytes. Tickets count by their names if there are any.
std::uint64_t DigestEffects(std::span<const Effect> effects, TicketNames* tickets = nullptr);
/// "HelloReceived", as in events.h.
std::string_view KindOf(const Event& event);

std::vector<std::uint8_t> EncodeHeader(const RecordingHeader& header);
std::vector<std::uint8_t> EncodeEvent(const Event& event, ServerTime time, std::uint64_t digest,
                                      TicketNames* tickets = nullptr);
/// Whatever the bytes. Errors: Corrupt.
Result<RecordingHeader> DecodeHeader(std::span<const std::uint8_t> bytes);
Result<RecordedEvent> DecodeEvent(std::span<const std::uint8_t> bytes);

/// Reads a recording piece by piece. Thread-compatible.
class RecordingReader {
 public:
  /// Errors: NotFound, Unsupported (another version), Corrupt.
  static Result<RecordingReader> Open(const std::filesystem::path& path);
  /// As Open; for bytes that are in memory.
  static Result<RecordingReader> FromBytes(std::vector<std::uint8_t> bytes);

  const RecordingHeader& header() const { return header_; }
  /// The next event; nothing at the end, which may be one that was cut off.
  /// Errors: Corrupt with the number of the damaged event.
  Result<std::optional<RecordedEvent>> Next();
  std::uint64_t events() const { return events_; }  ///< read so far
  /// Bytes at the end that are no whole event; known once Next gave nothing.
  std::size_t cut_off() const { return cut_off_; }

 private:
  RecordingReader() = default;
  Result<std::optional<std::span<const std::uint8_t>>> NextRecord();

  std::vector<std::uint8_t> bytes_;
  std::size_t at_ = 0;
  std::uint64_t events_ = 0;
  std::size_t cut_off_ = 0;
  RecordingHeader header_;
};

}  // namespace waymark::session::recording
