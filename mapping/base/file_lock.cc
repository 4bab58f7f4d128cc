// SPDX-License-Identifier: Apache-2.0
#include "mapping/base/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "mapping/base/internal/posix.h"

namespace waymark {

using internal::SystemError;

Result<FileLock> FileLock::Acquire(const std::filesystem::path& path, std::string_view purpose) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor < 0) return SystemError(path, "create lock file");
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    const bool taken = errno == EWOULDBLOCK;
    const Error error = taken ? MakeError(ErrorCode::kConflict, "{}: is in use by another {}",
                                          path.parent_path().string(), purpose)
                              : SystemError(path, "lock");
    ::close(descriptor);
    return error;
  }
  return FileLock(descriptor);
}

FileLock::FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FileLock& FileLock::operator=(FileLock&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace waymark
