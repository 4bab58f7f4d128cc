// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "mapping/base/result.h"

namespace waymark::internal {

/// Reads errno first. NotFound for a missing file, otherwise Unavailable.
inline Error SystemError(const std::filesystem::path& path, std::string_view action) {
  const int reason = errno;
  return MakeError(reason == ENOENT ? ErrorCode::kNotFound : ErrorCode::kUnavailable,
                   "{}: cannot {}: {}", path.string(), action, std::strerror(reason));
}

/// Owns a POSIX descriptor for the length of one function.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  int get() const { return value_; }
  bool valid() const { return value_ >= 0; }

 private:
  int value_;
};

}  // namespace waymark::internal
