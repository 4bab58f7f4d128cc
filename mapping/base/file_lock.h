// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "mapping/base/result.h"

namespace waymark {

/// An exclusive advisory lock on a file, held until destruction or the end of the process.
class FileLock {
 public:
  /// Errors: Conflict when another process holds it, Unavailable when the file cannot be made.
  /// `purpose` completes "… is in use by another <purpose>".
  static Result<FileLock> Acquire(const std::filesystem::path& path, std::string_view purpose);

  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&& other) noexcept;
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

 private:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_ = -1;
};

}  // namespace waymark
