// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "session/recording/recording.h"

namespace waymark::session::recording {

/// Writes a session down while it goes on. Events are in the file half a second later at most. What
/// cannot be written any more (a full disk, a disk that is slower than the session) is logged once
/// and ends the recording, never the session. Write is for one thread.
class Recorder {
 public:
  /// The file must not be there yet; only its owner may read it.
  /// Errors: Conflict (it is there), Unavailable.
  static Result<std::unique_ptr<Recorder>> Create(const std::filesystem::path& path,
                                                  const RecordingHeader& header);
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  ~Recorder();  ///< writes what waits

  /// What came of the event must be handed over before the next event.
  void Write(const Event& event, ServerTime time, std::span<const Effect> effects);

  /// Nothing is lost so far.
  bool IsRecording() const;

 private:
  Recorder(std::filesystem::path path, int file) : path_(std::move(path)), file_(file) {}

  void Append(std::span<const std::uint8_t> record);
  void Work();
  bool Store(std::span<const std::uint8_t> bytes);
  void GiveUp(const std::string& why);

  const std::filesystem::path path_;
  const int file_;
  TicketNames tickets_;  // the writing thread's
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::uint8_t> waiting_;  // guarded by mutex_
  bool is_recording_ = true;           // guarded by mutex_
  bool is_ending_ = false;             // guarded by mutex_
  std::thread thread_;
};

}  // namespace waymark::session::recording
