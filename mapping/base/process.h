// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark {

/// What a program that ran to its end left behind.
struct ProgramOutcome {
  int status = 0;      ///< exit status; 128 + signal when a signal ended it
  std::string output;  ///< of stdout and stderr, as they came
};

/// Runs a program, found through PATH, with nothing on its standard input, and waits for it. No
/// shell is between: arguments arrive as they are.
/// Errors: Unavailable when it cannot be started.
Result<ProgramOutcome> CaptureProgram(const std::vector<std::string>& words);

}  // namespace waymark
