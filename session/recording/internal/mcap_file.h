// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::session::recording::internal {

/// An MCAP file: messages in chunks of about a megabyte, compressed with Zstandard, and at the end
/// an index of them, so that a player seeks in hours of them without reading them all.
/// Source: mcap.dev/spec, "MCAP Format Specification". Thread-compatible.
class McapFile {
 public:
  /// Errors: Unavailable.
  static Result<McapFile> Create(const std::filesystem::path& path, std::string_view library);

  /// Say the number by which it is known: of a schema in channels, of a channel in messages.
  std::uint16_t AddSchema(std::string_view name, std::string_view json_schema);
  std::uint16_t AddChannel(std::string_view topic, std::uint16_t schema);
  /// JSON, at a time of the wall clock; times do not go back.
  void AddMessage(std::uint16_t channel, std::uint64_t ns, std::string_view json);
  /// Writes what is left and the index. Errors: Unavailable when something could not be written.
  Result<void> Finish();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  /// Messages that are not written yet.
  struct Chunk {
    std::string records;
    std::uint64_t first_ns = 0, last_ns = 0;
    /// By channel: time, and place within the chunk.
    std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> messages;
  };
  struct Span {
    std::uint8_t kind = 0;
    std::uint64_t begin = 0, size = 0;
  };

  McapFile(std::filesystem::path path, std::FILE* file) : path_(std::move(path)), file_(file) {}

  void Write(std::string_view bytes);
  void Put(std::uint8_t kind, std::string_view content);
  void WriteChunk();
  /// Records of one kind in the summary.
  Span PutGroup(std::uint8_t kind, const std::vector<std::string>& contents);
  std::string Statistics() const;

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Closer> file_;
  std::uint64_t written_ = 0;  // octets
  std::vector<std::string> schemas_, channels_, chunk_indexes_;
  Chunk chunk_;
  std::map<std::uint16_t, std::uint64_t> counts_;  // messages of a channel
  std::uint64_t first_ns_ = 0, last_ns_ = 0;
  std::uint32_t sequence_ = 0;
};

}  // namespace waymark::session::recording::internal
