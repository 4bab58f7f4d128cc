// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mapping/base/result.h"

namespace waymark {

/// Reads a whole file. Errors: NotFound, Unavailable (cannot be read), each naming the path.
Result<std::vector<std::uint8_t>> LoadFile(const std::filesystem::path& path);
Result<std::string> LoadTextFile(const std::filesystem::path& path);

/// Replaces a file so that after a crash either the old or the whole new content is there:
/// temporary file in the same folder, fsync, rename, fsync of the folder.
/// Errors: Unavailable with the path and the system's reason (full disk, no permission).
Result<void> StoreFileAtomically(const std::filesystem::path& path,
                                 std::span<const std::uint8_t> bytes);
Result<void> StoreFileAtomically(const std::filesystem::path& path, std::string_view text);

/// Creates a folder and its parents and makes their existence durable.
Result<void> CreateFolders(const std::filesystem::path& path);

/// A whole file mapped read-only. Movable, unmapped on destruction. Immutable, thread-safe.
class MappedFile {
 public:
  /// Errors: NotFound, Unavailable; an empty file maps to an empty span.
  static Result<MappedFile> Open(const std::filesystem::path& path);

  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  std::span<const std::uint8_t> bytes() const { return {data_, size_}; }

 private:
  MappedFile(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  const std::uint8_t* data_ = nullptr;
  std::size_t size_ = 0;
};

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
