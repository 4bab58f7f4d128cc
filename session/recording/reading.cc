// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "mapping/base/content_hash.h"
#include "mapping/base/file.h"
#include "session/recording/internal/frame.h"
#include "session/recording/recording.h"

namespace waymark::session::recording {

Result<RecordingReader> RecordingReader::Open(const std::filesystem::path& path) {
  WAYMARK_TRY_ASSIGN(auto bytes, LoadFile(path));
  auto reader = FromBytes(std::move(bytes));
  if (reader.ok()) return reader;
  return MakeError(reader.error().code, "{}: {}", path.string(), reader.error().message);
}

Result<RecordingReader> RecordingReader::FromBytes(std::vector<std::uint8_t> bytes) {
  RecordingReader reader;
  reader.bytes_ = std::move(bytes);
  const std::string_view text(reinterpret_cast<const char*>(reader.bytes_.data()),
                              reader.bytes_.size());
  std::uint32_t version = 0;
  if (!text.starts_with(internal::kMagic) ||
      text.size() < internal::kMagic.size() + sizeof version) {
    return MakeError(ErrorCode::kCorrupt, "expected a recording of waymark-serve");
  }
  std::memcpy(&version, text.data() + internal::kMagic.size(), sizeof version);
  if (version != kFormatVersion) {
    return MakeError(ErrorCode::kUnsupported, "expected a recording of version {}, found {}",
                     kFormatVersion, version);
  }
  reader.at_ = internal::kMagic.size() + sizeof version;
  WAYMARK_TRY_ASSIGN(const auto record, reader.NextRecord());
  if (!record) return MakeError(ErrorCode::kCorrupt, "the recording ends in its head");
  WAYMARK_TRY_ASSIGN(reader.header_, DecodeHeader(*record));
  return reader;
}

Result<std::optional<std::span<const std::uint8_t>>> RecordingReader::NextRecord() {
  using Found = std::optional<std::span<const std::uint8_t>>;
  const std::span<const std::uint8_t> rest = std::span(bytes_).subspan(at_);
  internal::RecordHead head;
  cut_off_ = rest.size();
  if (rest.size() < internal::kRecordHeadBytes) return Found();
  std::memcpy(&head.size, rest.data(), sizeof head.size);
  std::memcpy(&head.checksum, rest.data() + sizeof head.size, sizeof head.checksum);
  if (rest.size() - internal::kRecordHeadBytes < head.size) return Found();
  const auto record = rest.subspan(internal::kRecordHeadBytes, head.size);
  if (Checksum(record) != head.checksum) {
    return MakeError(ErrorCode::kCorrupt, "its checksum says that it is damaged");
  }
  at_ += internal::kRecordHeadBytes + head.size;
  cut_off_ = 0;
  return Found(record);
}

Result<std::optional<RecordedEvent>> RecordingReader::Next() {
  const auto named = [&](const Error& error) {
    return Error{error.code, fmt::format("event {}: {}", events_ + 1, error.message)};
  };
  const auto record = NextRecord();
  if (!record) return named(record.error());
  if (!*record) return std::optional<RecordedEvent>();
  auto event = DecodeEvent(**record);
  if (!event) return named(event.error());
  ++events_;
  return std::optional(*std::move(event));
}

}  // namespace waymark::session::recording
