// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::bench {

/// What a program took, or several one after the other.
struct Usage {
  double wall_s = 0;
  double cpu_s = 0;
  double peak_mib = 0;  ///< resident, of the largest

  Usage& operator+=(const Usage& other);
};

/// Runs a program and waits for it; its output goes to the end of `log`.
/// Errors: Unavailable when it does not end with 0.
Result<Usage> RunTimed(const std::string& program, const std::vector<std::string>& arguments,
                       const std::filesystem::path& log);

}  // namespace waymark::bench
