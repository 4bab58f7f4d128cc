// SPDX-License-Identifier: Apache-2.0
#include "session/recording/recorder.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "mapping/base/content_hash.h"
#include "mapping/base/log.h"
#include "session/recording/internal/frame.h"

namespace waymark::session::recording {
namespace {

constexpr std::chrono::milliseconds kFlushInterval{250};
constexpr std::size_t kFlushBytes = 1024 * 1024;
constexpr std::size_t kMaxWaitingBytes = 64 * 1024 * 1024;

template <typename T>
void AppendNumber(std::vector<std::uint8_t>& bytes, T number) {
  const auto* const begin = reinterpret_cast<const std::uint8_t*>(&number);
  bytes.insert(bytes.end(), begin, begin + sizeof number);
}

}  // namespace

Result<std::unique_ptr<Recorder>> Recorder::Create(const std::filesystem::path& path,
                                                   const RecordingHeader& header) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) {
    return MakeError(errno == EEXIST ? ErrorCode::kConflict : ErrorCode::kUnavailable,
                     "recording {}: {}", path.string(), std::strerror(errno));
  }
  std::unique_ptr<Recorder> recorder(new Recorder(path, file));
  std::vector<std::uint8_t>& bytes = recorder->waiting_;
  bytes.assign(internal::kMagic.begin(), internal::kMagic.end());
  AppendNumber(bytes, kFormatVersion);
  recorder->Append(EncodeHeader(header));
  recorder->thread_ = std::thread([raw = recorder.get()] { raw->Work(); });
  return recorder;
}

Recorder::~Recorder() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
  ::close(file_);
}

bool Recorder::IsRecording() const {
  const std::lock_guard lock(mutex_);
  return is_recording_;
}

void Recorder::Write(const Event& event, ServerTime time, std::span<const Effect> effects) {
  if (const auto* const hello = std::get_if<event::HelloReceived>(&event)) {
    tickets_.Add(hello->fresh_ticket);
  }
  for (const Effect& effect : effects) {
    const auto* const sent = std::get_if<effect::SendWelcome>(&effect);
    if (sent && sent->welcome.verdict == JoinVerdict::kAccepted) {
      tickets_.Keep(sent->welcome.ticket);
    }
  }
  Append(EncodeEvent(event, time, DigestEffects(effects, &tickets_), &tickets_));
}

void Recorder::Append(std::span<const std::uint8_t> record) {
  const std::lock_guard lock(mutex_);
  if (!is_recording_) return;
  if (waiting_.size() + record.size() > kMaxWaitingBytes) {
    return GiveUp("the disk is slower than the session");
  }
  AppendNumber(waiting_, static_cast<std::uint32_t>(record.size()));
  AppendNumber(waiting_, Checksum(record));
  waiting_.insert(waiting_.end(), record.begin(), record.end());
  if (waiting_.size() >= kFlushBytes) changed_.notify_all();
}

// With mutex_ held.
void Recorder::GiveUp(const std::string& why) {
  is_recording_ = false;
  waiting_ = {};
  LogError("recording {}: ends here, the session goes on: {}", path_.string(), why);
}

void Recorder::Work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait_for(lock, kFlushInterval,
                      [this] { return is_ending_ || waiting_.size() >= kFlushBytes; });
    const std::vector<std::uint8_t> bytes = std::exchange(waiting_, {});
    const bool is_last = is_ending_;
    lock.unlock();
    const bool is_stored = Store(bytes);
    const std::string why = is_stored ? "" : std::strerror(errno);
    lock.lock();
    if (!is_stored && is_recording_) GiveUp(why);
    if (is_last) return;
  }
}

bool Recorder::Store(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace waymark::session::recording
