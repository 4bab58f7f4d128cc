// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "session/recording/recording.h"

namespace waymark::session::recording {

namespace internal {
class McapFile;
}

/// Writes what a session showed as an MCAP file, so that Foxglove plays it: where devices were
/// (foxglove.PosesInFrame) and which anchors there are (foxglove.SceneUpdate), a topic each per
/// room, as JSON, in the frame "map".
class McapWriter {
 public:
  /// Errors: Unavailable.
  static Result<McapWriter> Create(const std::filesystem::path& path,
                                   const RecordingHeader& header);
  McapWriter(McapWriter&& other) noexcept;
  McapWriter& operator=(McapWriter&& other) noexcept;
  ~McapWriter();

  void Add(const RecordedEvent& event, std::span<const Effect> effects);
  /// Ends the file. Errors: Unavailable when something could not be written.
  Result<void> Finish();

 private:
  McapWriter(std::unique_ptr<internal::McapFile> file, std::int64_t start_ns);

  void AddTo(const std::string& topic, std::uint16_t schema, ServerTime time,
             const std::string& json);

  std::unique_ptr<internal::McapFile> file_;
  std::int64_t start_ns_;        // of the wall clock, when the first event happened
  std::uint16_t poses_, scene_;  // schemas
  std::optional<ServerTime> began_;
  std::map<std::string, std::uint16_t> channels_;
};

}  // namespace waymark::session::recording
