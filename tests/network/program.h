// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/network/network_namespace.h"

namespace waymark::network {

/// A program in a namespace, which says one line when it is ready. It ends with this object at the
/// latest.
class Program {
 public:
  /// What it says goes to the end of `log`. Errors: Unavailable (it cannot be started, or ended
  /// before it was ready).
  static Result<Program> Start(const NetworkNamespace& inside,
                               const std::vector<std::string>& words,
                               const std::filesystem::path& log);
  Program(Program&& other) noexcept;
  Program& operator=(Program&& other) noexcept;
  ~Program() { Kill(); }

  const std::string& line() const { return line_; }
  /// Ends it without any warning.
  void Kill();

  /// Processor time so far.
  double CpuS() const;
  /// Resident memory.
  double MemoryMib() const;
  /// Open file descriptors.
  int Descriptors() const;

 private:
  explicit Program(pid_t process) : process_(process) {}

  pid_t process_;
  std::string line_;
};

}  // namespace waymark::network
