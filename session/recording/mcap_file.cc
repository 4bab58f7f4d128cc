// SPDX-License-Identifier: Apache-2.0
#include "session/recording/internal/mcap_file.h"

#include <zstd.h>

#include <cerrno>
#include <cstring>

namespace waymark::session::recording::internal {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::string_view kCompression = "zstd";
constexpr int kLevel = 3;
constexpr std::size_t kChunkBytes = 1 << 20;

enum Kind : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f,
};

/// A record's fields, little-endian.
class Fields {
 public:
  template <typename T>
  Fields& Add(T number) {
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof number);
    return *this;
  }
  /// What is preceded by its length, as a number of that type.
  template <typename Length = std::uint32_t>
  Fields& AddText(std::string_view text) {
    Add(static_cast<Length>(text.size()));
    bytes_.append(text);
    return *this;
  }
  Fields& AddRest(std::string_view bytes) {
    bytes_.append(bytes);
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

std::string Record(std::uint8_t kind, std::string_view content) {
  return Fields().Add(kind).AddText<std::uint64_t>(content).bytes();
}

std::string Compress(std::string_view bytes) {
  std::string compressed(::ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size =
      ::ZSTD_compress(compressed.data(), compressed.size(), bytes.data(), bytes.size(), kLevel);
  CHECK(::ZSTD_isError(size) == 0);  // the bound holds
  compressed.resize(size);
  return compressed;
}

}  // namespace

Result<McapFile> McapFile::Create(const std::filesystem::path& path, std::string_view library) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) {
    return MakeError(ErrorCode::kUnavailable, "{}: {}", path.string(), std::strerror(errno));
  }
  McapFile mcap(path, file);
  mcap.Write(kMagic);
  mcap.Put(kHeader, Fields().AddText("").AddText(library).bytes());
  return mcap;
}

void McapFile::Write(std::string_view bytes) {
  (void)std::fwrite(bytes.data(), 1, bytes.size(), file_.get());  // Finish looks for errors
  written_ += bytes.size();
}

void McapFile::Put(std::uint8_t kind, std::string_view content) { Write(Record(kind, content)); }

std::uint16_t McapFile::AddSchema(std::string_view name, std::string_view json_schema) {
  const auto number = static_cast<std::uint16_t>(schemas_.size() + 1);
  schemas_.push_back(
      Fields().Add(number).AddText(name).AddText("jsonschema").AddText(json_schema).bytes());
  Put(kSchema, schemas_.back());
  return number;
}

std::uint16_t McapFile::AddChannel(std::string_view topic, std::uint16_t schema) {
  const auto number = static_cast<std::uint16_t>(channels_.size() + 1);
  const std::uint32_t no_metadata = 0;
  channels_.push_back(
      Fields().Add(number).Add(schema).AddText(topic).AddText("json").Add(no_metadata).bytes());
  // Among the messages, for who reads the file from its beginning.
  chunk_.records += Record(kChannel, channels_.back());
  return number;
}

void McapFile::AddMessage(std::uint16_t channel, std::uint64_t ns, std::string_view json) {
  if (chunk_.messages.empty()) chunk_.first_ns = ns;
  if (counts_.empty()) first_ns_ = ns;
  chunk_.last_ns = last_ns_ = ns;
  ++counts_[channel];
  chunk_.messages[channel].emplace_back(ns, chunk_.records.size());
  chunk_.records += Record(
      kMessage, Fields().Add(channel).Add(sequence_++).Add(ns).Add(ns).AddRest(json).bytes());
  if (chunk_.records.size() >= kChunkBytes) WriteChunk();
}

void McapFile::WriteChunk() {
  if (chunk_.records.empty()) return;
  const std::uint64_t begin = written_, size = chunk_.records.size();
  const std::string compressed = Compress(chunk_.records);
  const std::uint32_t no_checksum = 0;
  Put(kChunk, Fields()
                  .Add(chunk_.first_ns)
                  .Add(chunk_.last_ns)
                  .Add(size)
                  .Add(no_checksum)
                  .AddText(kCompression)
                  .AddText<std::uint64_t>(compressed)
                  .bytes());
  const std::uint64_t end = written_;
  Fields places;
  for (const auto& [channel, messages] : chunk_.messages) {
    places.Add(channel).Add(written_);
    Fields entries;
    for (const auto& [ns, place] : messages) entries.Add(ns).Add(place);
    Put(kMessageIndex, Fields().Add(channel).AddText(entries.bytes()).bytes());
  }
  chunk_indexes_.push_back(Fields()
                               .Add(chunk_.first_ns)
                               .Add(chunk_.last_ns)
                               .Add(begin)
                               .Add(end - begin)
                               .AddText(places.bytes())
                               .Add(written_ - end)
                               .AddText(kCompression)
                               .Add(std::uint64_t{compressed.size()})
                               .Add(size)
                               .bytes());
  chunk_ = {};
}

McapFile::Span McapFile::PutGroup(std::uint8_t kind, const std::vector<std::string>& contents) {
  const std::uint64_t begin = written_;
  for (const std::string& content : contents) Put(kind, content);
  return {kind, begin, written_ - begin};
}

std::string McapFile::Statistics() const {
  std::uint64_t messages = 0;
  Fields by_channel;
  for (const auto& [channel, count] : counts_) {
    messages += count;
    by_channel.Add(channel).Add(count);
  }
  const std::uint32_t none = 0;
  return Fields()
      .Add(messages)
      .Add(static_cast<std::uint16_t>(schemas_.size()))
      .Add(static_cast<std::uint32_t>(channels_.size()))
      .Add(none)  // attachments
      .Add(none)  // metadata
      .Add(static_cast<std::uint32_t>(chunk_indexes_.size()))
      .Add(first_ns_)
      .Add(last_ns_)
      .AddText(by_channel.bytes())
      .bytes();
}

Result<void> McapFile::Finish() {
  WriteChunk();
  const std::uint32_t no_checksum = 0;
  Put(kDataEnd, Fields().Add(no_checksum).bytes());
  const std::uint64_t summary = written_;
  const std::vector<Span> groups{PutGroup(kSchema, schemas_), PutGroup(kChannel, channels_),
                                 PutGroup(kStatistics, {Statistics()}),
                                 PutGroup(kChunkIndex, chunk_indexes_)};
  const std::uint64_t offsets = written_;
  for (const Span& group : groups) {
    if (group.size == 0) continue;
    Put(kSummaryOffset, Fields().Add(group.kind).Add(group.begin).Add(group.size).bytes());
  }
  Put(kFooter, Fields().Add(summary).Add(offsets).Add(no_checksum).bytes());
  Write(kMagic);
  const bool is_written = std::fflush(file_.get()) == 0 && std::ferror(file_.get()) == 0;
  if (is_written) return {};
  return MakeError(ErrorCode::kUnavailable, "{}: could not be written: {}", path_.string(),
                   std::strerror(errno));
}

}  // namespace waymark::session::recording::internal
