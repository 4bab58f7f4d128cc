// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <vector>

namespace waymark::content {

enum class DiskFault {
  kNone,
  kFull,      ///< a write finds no space
  kTorn,      ///< a write reaches the disk in part and fails
  kWrite,     ///< a write fails
  kSync,      ///< a sync fails
  kLostSync,  ///< every sync from then on is acknowledged and does nothing
};

/// Stands between SQLite and the files of one folder as its default file system: fails the
/// operation that a plan names, and can say what a power cut would leave. One at a time.
class FaultyDisk {
 public:
  explicit FaultyDisk(std::filesystem::path folder);
  FaultyDisk(const FaultyDisk&) = delete;
  FaultyDisk& operator=(const FaultyDisk&) = delete;
  ~FaultyDisk();

  /// The `at`-th operation of the fault's kind from now on, counted from 1, meets it.
  void Plan(DiskFault fault, std::uint64_t at);
  bool has_struck() const { return has_struck_; }

  /// Writes what a power cut now would leave: files as synced, and of the sectors written since
  /// any part.
  void Cut(const std::filesystem::path& into, std::mt19937_64& random);

  // For the file system's functions.
  bool Watches(const std::string& path) const { return path.starts_with(folder_.string()); }
  /// The fault that this operation meets.
  DiskFault OnWrite(const std::string& path, const std::vector<char>& before, std::int64_t offset);
  DiskFault OnSync(const std::string& path);
  void OnTruncate(const std::string& path, const std::vector<char>& before);
  void OnDelete(const std::string& path);

 private:
  /// Bytes of a file as they were before a write that is not synced yet.
  struct Before {
    std::int64_t offset;
    std::vector<char> bytes;
  };

  const std::filesystem::path folder_;
  std::mutex mutex_;
  DiskFault fault_ = DiskFault::kNone;  // guarded by mutex_, like what follows
  std::uint64_t left_ = 0;
  bool has_struck_ = false;
  std::map<std::string, std::vector<Before>> unsynced_;
};

}  // namespace waymark::content
