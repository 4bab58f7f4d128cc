// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark {

/// What a program that ran to its end left behind.
struct ProgramOutcome {
  int status = 0;      ///< exit status; 128 + signal when a signal ended it
  std::string output;  ///< of stdout and stderr, as they came
};

/// Starts a program, found through PATH, with nothing on its standard input; what it prints and
/// complains of goes to the file descriptor `output`. No shell is between: arguments arrive as they
/// are. The caller waits for it.
/// Errors: Unavailable when it cannot be started.
Result<pid_t> StartProgram(std::vector<std::string> words, int output);

/// Runs a program as `StartProgram` and waits for it.
/// Errors: Unavailable when it cannot be started.
Result<ProgramOutcome> CaptureProgram(const std::vector<std::string>& words);

}  // namespace waymark
