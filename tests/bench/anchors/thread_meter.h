// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

namespace waymark::bench {

/// What the kernel counted for a thread so far; differences are what is of use.
struct ThreadCounts {
  double waited_s = 0;         ///< ready to run, while other threads had the processors
  std::uint64_t reads = 0;     ///< calls that read a file, but those of the meter
  double from_disk_bytes = 0;  ///< read from a disk, not from memory
};

/// The counts of the thread that makes it. Source: Linux, Documentation/scheduler/sched-stats,
/// "/proc/<pid>/schedstat"; Documentation/filesystems/proc, "/proc/<pid>/io".
class ThreadMeter {
 public:
  ThreadMeter();
  ~ThreadMeter();
  ThreadMeter(const ThreadMeter&) = delete;
  ThreadMeter& operator=(const ThreadMeter&) = delete;

  ThreadCounts Read();

 private:
  std::string ReadAll(int file);

  const int schedule_, io_;      // files of /proc
  std::uint64_t own_reads_ = 0;  // of those files
};

}  // namespace waymark::bench
