// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/stat.h>
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

inline Result<std::size_t> SizeOfRegularFile(const Descriptor& descriptor,
                                             const std::filesystem::path& path) {
  struct stat status {};
  if (::fstat(descriptor.get(), &status) != 0) return SystemError(path, "read");
  if (!S_ISREG(status.st_mode)) {
    return MakeError(ErrorCode::kInvalidArgument, "{}: expected a regular file", path.string());
  }
  return static_cast<std::size_t>(status.st_size);
}

}  // namespace waymark::internal
