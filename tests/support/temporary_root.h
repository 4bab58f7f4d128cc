// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace waymark::support {

/// Where tests that write often may put a folder of their own: in memory where there is such a
/// place, since disks that others keep busy took 90 ms for each sync.
inline std::filesystem::path TemporaryRoot() {
  const std::filesystem::path memory("/dev/shm");
  return std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
}

}  // namespace waymark::support
