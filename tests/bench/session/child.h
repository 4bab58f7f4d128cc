// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::bench {

/// A program in another process, which stays until it is told to end.
class Child {
 public:
  /// This program, which says one line when it is ready.
  /// Errors: Unavailable (it cannot be started, or says nothing).
  static Result<Child> Start(const std::vector<std::string>& arguments);
  /// Another one, found through PATH, what it says goes nowhere. Errors: Unavailable.
  static Result<Child> StartOther(const std::vector<std::string>& words);
  Child(Child&& other) noexcept;
  ~Child();

  const std::string& line() const { return line_; }
  /// What it says after that. Errors: Unavailable (it ended).
  Result<std::string> NextLine() const;
  /// Says something to a program of ours: a signal that it waits for.
  void Signal(int signal) const;
  /// Processor time so far.
  double CpuS() const;
  /// Resident memory.
  double MemoryMib() const;
  /// Open files.
  int Descriptors() const;

 private:
  class Said;

  Child(pid_t process, std::shared_ptr<Said> said, std::string line)
      : process_(process), said_(std::move(said)), line_(std::move(line)) {}

  pid_t process_;
  std::shared_ptr<Said> said_;  // null: nobody listens
  std::string line_;
};

/// Processor time of this process so far.
double OwnCpuS();

}  // namespace waymark::bench
