// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "localiser/localiser.h"

namespace waymark::localiser {

/// What waymark-localise is told on its command line.
struct LocaliseArguments {
  std::string map, out, camera, list;
  std::vector<std::string> queries;  ///< one folder, or the images of a burst
  std::string odometry;              ///< empty: no burst
  std::vector<double> odometry_up{0, 0, 1};
  int threads = 0;
  double memory_mb = 0;  ///< 0: no limit
  SearchMethod search = SearchMethod::kInvertedLists;
  bool no_prior = false;
  bool verbose = false;
};

/// Declares the options on the app; the arguments are set when it parses.
void AddLocaliseOptions(CLI::App& app, LocaliseArguments& arguments);

}  // namespace waymark::localiser
