// SPDX-License-Identifier: Apache-2.0
#include "session/device/c/boundary.h"

#include <algorithm>

namespace waymark::session::c {
namespace {

constexpr std::size_t kMaxStructBytes = 16 * 1024;  // more is no size but chance

thread_local std::string answered_message;

WaymarkStatus StatusOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return WAYMARK_INVALID_ARGUMENT;
    case ErrorCode::kNotFound:
      return WAYMARK_NOT_FOUND;
    case ErrorCode::kConflict:
      return WAYMARK_CONFLICT;
    case ErrorCode::kUnavailable:
      return WAYMARK_UNAVAILABLE;
    case ErrorCode::kTimeout:
      return WAYMARK_TIMEOUT;
    case ErrorCode::kCorrupt:
      return WAYMARK_CORRUPT;
    case ErrorCode::kUnsupported:
      return WAYMARK_UNSUPPORTED;
  }
  return WAYMARK_INTERNAL;
}

}  // namespace

Outcome::Outcome(const Error& error) : status(StatusOf(error.code)), message(error.message) {}

WaymarkStatus Answer(Outcome outcome) noexcept {
  answered_message.swap(outcome.message);
  return outcome.status;
}

const char* AnsweredMessage() noexcept { return answered_message.c_str(); }

Result<void> Need(const void* argument, const char* name) {
  if (argument != nullptr) return {};
  return MakeError(ErrorCode::kInvalidArgument, "{}: is NULL", name);
}

Result<std::string> ReadText(const char* text, std::size_t max_bytes, const char* name) {
  WAYMARK_TRY(Need(text, name));
  const std::size_t length = ::strnlen(text, max_bytes + 1);
  if (length <= max_bytes) return std::string(text, length);
  return MakeError(ErrorCode::kInvalidArgument, "{}: expected at most {} bytes", name, max_bytes);
}

void WriteText(const std::string& text, char* out, std::size_t bytes) {
  const std::size_t length = std::min(text.size(), bytes - 1);
  std::memcpy(out, text.data(), length);
  std::memset(out + length, 0, bytes - length);
}

Result<std::size_t> ReadStructSize(const void* theirs, std::size_t first_size, const char* name) {
  WAYMARK_TRY(Need(theirs, name));
  std::uint32_t size = 0;
  std::memcpy(&size, theirs, sizeof(size));
  if (size >= first_size && size <= kMaxStructBytes && size % alignof(std::uint64_t) == 0) {
    return std::size_t{size};
  }
  return MakeError(ErrorCode::kInvalidArgument,
                   "{}: expected struct_size to be its sizeof, at least {}, found {}", name,
                   first_size, size);
}

Result<void> NeedZeros(const void* theirs, std::size_t from, std::size_t to, const char* name) {
  const auto* const bytes = static_cast<const std::uint8_t*>(theirs);
  if (std::all_of(bytes + from, bytes + to, [](std::uint8_t byte) { return byte == 0; })) return {};
  return MakeError(ErrorCode::kUnsupported,
                   "{}: says more than version {} of this library understands", name,
                   WAYMARK_ABI_VERSION);
}

}  // namespace waymark::session::c
