// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "mapping/base/stopwatch.h"
#include "tests/evaluation/running.h"
#include "tests/evaluation/scenarios.h"

namespace waymark::evaluation {
namespace {

constexpr int kSkipped = 77;  // what ctest takes for a skip

struct Arguments {
  std::string data, programs, only;
  int threads = 0;
  bool keep = false;
};

// True when the scenario kept its promise.
bool RunAndReport(const Scenario& scenario, const Workplace& place) {
  const Stopwatch watch;
  std::error_code ignored;
  Finding finding;
  if (!std::filesystem::is_directory(place.data / scenario.data, ignored)) {
    finding.measured = "skipped: no folder " + scenario.data;
  } else if (auto found = scenario.run(place)) {
    finding = *std::move(found);
  } else {
    finding = {"failed: " + ToString(found.error()), "to run", false};
  }
  fmt::print("{:36} {:62} {:28} {:5} {:7.1f}\n", scenario.name, finding.measured, finding.target,
             finding.target.empty() ? ""
             : finding.held         ? "held"
                                    : "MISSED",
             watch.ElapsedS());
  std::fflush(stdout);
  return finding.held;
}

int Evaluate(const Arguments& arguments) {
  if (arguments.data.empty()) {
    fmt::print("skipped: WAYMARK_DATA names no folder of data, and --data is not given\n");
    return kSkipped;
  }
  const ScratchFolder scratch(arguments.keep);
  const Workplace place{arguments.programs, arguments.data, scratch.path(),
                        std::to_string(arguments.threads)};
  fmt::print("{:36} {:62} {:28} {:5} {:>7}\n", "scenario", "measured", "target", "", "seconds");
  int missed = 0;
  for (const Scenario& scenario : Scenarios()) {
    if (scenario.name.find(arguments.only) == std::string::npos) continue;
    missed += !RunAndReport(scenario, place);
  }
  fmt::print("{}\n", missed == 0 ? "all targets held" : fmt::format("{} targets missed", missed));
  return missed == 0 ? 0 : 1;
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Builds maps from real photographs with waymark-map, finds images in them with\n"
      "waymark-localise, and compares both with the ground truth, as one table.");
  app.footer(
      "Example: WAYMARK_DATA=/path/to/data waymark-evaluate-real-data\n"
      "Exit status: 0 every target held, 1 one was missed, 77 there is no data.");
  Arguments arguments;
  arguments.programs = ExecutableFolder().string();
  app.add_option("--data", arguments.data, "folder of fountain, kitti_clip_1, …")
      ->envname("WAYMARK_DATA");
  app.add_option("--programs", arguments.programs, "folder of waymark-map and waymark-localise")
      ->capture_default_str();
  app.add_option("--only", arguments.only, "run scenarios whose name contains this");
  app.add_option("--threads", arguments.threads, "0: all cores")->check(CLI::Range(0, 1024));
  app.add_flag("--keep", arguments.keep, "keep maps, tables and logs, and say where");
  CLI11_PARSE(app, argc, argv);
  return Evaluate(arguments);
}

}  // namespace
}  // namespace waymark::evaluation

int main(int argc, char** argv) { return waymark::evaluation::Run(argc, argv); }
