// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "session/recording/recording.h"

namespace waymark::session::recording {

/// Writes what a session showed as an MCAP file, so that Foxglove plays it: where devices were
/// (foxglove.PosesInFrame) and which anchors there are (foxglove.SceneUpdate), a topic each per
/// room, as JSON, in the frame "map". Without chunks or index.
/// Source: mcap.dev/spec, "MCAP Format Specification".
class McapWriter {
 public:
  /// Errors: Unavailable.
  static Result<McapWriter> Create(const std::filesystem::path& path,
                                   const RecordingHeader& header);

  void Add(const RecordedEvent& event, std::span<const Effect> effects);
  /// Ends the file. Errors: Unavailable when something could not be written.
  Result<void> Finish();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  McapWriter(std::filesystem::path path, std::FILE* file, std::int64_t start_ns)
      : path_(std::move(path)), file_(file), start_ns_(start_ns) {}

  void AddTo(const std::string& topic, std::uint16_t schema, ServerTime time,
             const std::string& json);
  std::uint16_t ChannelOf(const std::string& topic, std::uint16_t schema);
  void Put(std::uint8_t kind, std::string_view content);

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Closer> file_;
  std::int64_t start_ns_;  // of the wall clock, when the first event happened
  std::optional<ServerTime> began_;
  std::map<std::string, std::uint16_t> channels_;
  std::uint32_t sequence_ = 0;
};

}  // namespace waymark::session::recording
