// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/anchors/processor.h"

#include <fmt/format.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>

namespace waymark::bench {
namespace {

namespace fs = std::filesystem;

/// Of the descendants of a process, which have one thread each.
double DescendantSeconds(long process) {
  double seconds = 0;
  std::error_code ignored;
  for (const auto& thread :
       fs::directory_iterator(fmt::format("/proc/{}/task", process), ignored)) {
    std::ifstream children(thread.path() / "children");
    for (long child = 0; children >> child;) {
      double ran_ns = 0;
      std::ifstream(fmt::format("/proc/{}/schedstat", child)) >> ran_ns;
      seconds += 1e-9 * ran_ns + DescendantSeconds(child);
    }
  }
  return seconds;
}

}  // namespace

double ProcessorSeconds() {
  timespec own{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &own);
  return static_cast<double>(own.tv_sec) + 1e-9 * static_cast<double>(own.tv_nsec) +
         DescendantSeconds(::getpid());
}

}  // namespace waymark::bench
