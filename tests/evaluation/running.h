// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::evaluation {

/// A folder of its own for one run, removed at the end unless kept.
class ScratchFolder {
 public:
  explicit ScratchFolder(bool keep);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  bool keep_;
};

/// The folder of the running executable, where its siblings are installed too.
std::filesystem::path ExecutableFolder();

/// What a program took, or several one after the other.
struct Usage {
  double wall_s = 0;
  double cpu_s = 0;
  double peak_mib = 0;  ///< resident, of the largest

  Usage& operator+=(const Usage& other);
};

/// Runs a program as a user would and waits for it; a bare name is looked up in PATH. Its output
/// goes to the end of `log`.
/// Errors: Unavailable when it cannot be started or does not end with 0; the message holds the last
/// lines of its output.
Result<Usage> RunProgram(const std::filesystem::path& program,
                         const std::vector<std::string>& arguments,
                         const std::filesystem::path& log);

}  // namespace waymark::evaluation
