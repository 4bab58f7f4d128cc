// SPDX-License-Identifier: Apache-2.0
#include "tests/content_store/sync_watch.h"

#include <fmt/format.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <utility>

namespace waymark::content {
namespace {

std::function<bool(const std::string&)> g_before;

int WatchedSync(long call, int descriptor) {
  if (g_before) {
    std::error_code ignored;
    const auto path =
        std::filesystem::read_symlink(fmt::format("/proc/self/fd/{}", descriptor), ignored);
    if (!g_before(path.string())) {
      errno = EIO;
      return -1;
    }
  }
  return static_cast<int>(::syscall(call, descriptor));
}

}  // namespace

SyncWatch::SyncWatch(std::function<bool(const std::string&)> before) {
  g_before = std::move(before);
}
SyncWatch::~SyncWatch() { g_before = nullptr; }

}  // namespace waymark::content

// The program's own symbols win over the C library's, in SQLite's shared library too.
extern "C" int fsync(int descriptor) {
  return waymark::content::WatchedSync(SYS_fsync, descriptor);
}
extern "C" int fdatasync(int descriptor) {
  return waymark::content::WatchedSync(SYS_fdatasync, descriptor);
}
