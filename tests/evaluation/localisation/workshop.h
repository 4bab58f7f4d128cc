// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "tests/evaluation/localisation/city_pictures.h"

namespace waymark::evaluation {

/// Where and on how many cores an evaluation works.
struct WorkshopArguments {
  std::string folder = (std::filesystem::temp_directory_path() / "waymark-evaluation").string();
  int threads = 0;
};

inline void AddWorkshopOptions(CLI::App& app, WorkshopArguments& arguments) {
  app.add_option("--work", arguments.folder, "folder that keeps pictures, features and submaps")
      ->capture_default_str();
  app.add_option("--threads", arguments.threads, "0: all cores")->check(CLI::Range(0, 1024));
}

/// With progress in one line of the terminal.
inline Workshop MakeWorkshop(const WorkshopArguments& arguments) {
  return {std::filesystem::absolute(arguments.folder),
          {arguments.threads},
          [](const std::string& what, std::size_t done, std::size_t total) {
            if (done % 10 != 0 && done != total) return;
            fmt::print(stderr, "\r{:32} {:6} of {:6}", what, done, total);
            if (done == total) fmt::print(stderr, "\n");
          }};
}

}  // namespace waymark::evaluation
