// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::support {

/// A file system of its own that can be full, seen by this thread and by what it starts from now
/// on, and gone with them. Needs root.
class SmallDisk {
 public:
  /// In an empty folder. Errors: Unavailable, with what is missing.
  static Result<SmallDisk> Mount(const std::filesystem::path& folder, std::size_t bytes) {
    const std::string options = "size=" + std::to_string(bytes);
    const bool is_mounted =
        ::unshare(CLONE_NEWNS) == 0 &&
        ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
        ::mount("none", folder.c_str(), "tmpfs", MS_NOSUID | MS_NODEV, options.c_str()) == 0;
    if (is_mounted) return SmallDisk(folder);
    return MakeError(ErrorCode::kUnavailable, "no file system of its own: {}",
                     std::strerror(errno));
  }
  SmallDisk(SmallDisk&& other) noexcept : folder_(std::move(other.folder_)) {
    other.folder_.clear();
  }
  SmallDisk& operator=(SmallDisk&&) = delete;
  ~SmallDisk() {
    if (!folder_.empty()) ::umount2(folder_.c_str(), MNT_DETACH);
  }

  const std::filesystem::path& folder() const { return folder_; }

  /// Until so many bytes are free, or up to 4 kB more.
  void FillUpTo(std::size_t free_bytes) const {
    const int file = ::open(Ballast().c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    const std::vector<char> page(4096, 'x');
    while (std::filesystem::space(folder_).available >= free_bytes + page.size() &&
           ::write(file, page.data(), page.size()) > 0) {
    }
    ::close(file);
  }
  void MakeRoom() const { std::filesystem::remove(Ballast()); }

 private:
  explicit SmallDisk(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path Ballast() const { return folder_ / "ballast"; }

  std::filesystem::path folder_;
};

}  // namespace waymark::support
