// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mapping/base/result.h"

namespace waymark::evaluation {

/// Where a run finds its programs and data, and may write.
struct Workplace {
  std::filesystem::path programs;  ///< holds waymark-map and waymark-localise
  std::filesystem::path data;      ///< as WAYMARK_DATA
  std::filesystem::path scratch;   ///< maps, tables and logs of this run
  std::string threads;             ///< passed on
};

/// What one scenario found, beside what was asked of it.
struct Finding {
  std::string measured;
  std::string target;  ///< empty: only reported
  bool held = true;
};

struct Scenario {
  std::string name;
  std::string data;  ///< the folder it needs below Workplace::data
  std::function<Result<Finding>(const Workplace&)> run;
};

/// All of them, in the order of the table.
std::vector<Scenario> Scenarios();

}  // namespace waymark::evaluation
