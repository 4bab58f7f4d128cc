// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/anchors/thread_meter.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

namespace waymark::bench {

std::string ThreadMeter::ReadAll(int file) {
  char text[512] = {};
  const ssize_t size = ::pread(file, text, sizeof text - 1, 0);
  ++own_reads_;  // the kernel counts a call when it ends
  return {text, size > 0 ? static_cast<std::size_t>(size) : 0};
}

ThreadMeter::ThreadMeter()
    : schedule_(::open("/proc/thread-self/schedstat", O_RDONLY)),
      io_(::open("/proc/thread-self/io", O_RDONLY)) {}

ThreadMeter::~ThreadMeter() {
  ::close(schedule_);
  ::close(io_);
}

ThreadCounts ThreadMeter::Read() {
  unsigned long long ran_ns = 0, waited_ns = 0, reads = 0, bytes = 0;
  (void)std::sscanf(ReadAll(schedule_).c_str(), "%llu %llu", &ran_ns, &waited_ns);
  const std::uint64_t own_reads = own_reads_;
  (void)std::sscanf(ReadAll(io_).c_str(),
                    "rchar: %*u wchar: %*u syscr: %llu syscw: %*u read_bytes: %llu", &reads,
                    &bytes);
  return {1e-9 * static_cast<double>(waited_ns), reads - own_reads, static_cast<double>(bytes)};
}

}  // namespace waymark::bench
