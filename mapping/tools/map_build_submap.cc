// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "mapping/pipeline/pipeline.h"
#include "mapping/tools/interruption.h"
#include "mapping/tools/map_commands.h"
#include "mapping/tools/progress_display.h"

namespace waymark::mapping {
namespace {

struct BuildArguments {
  std::string map;
  std::string task;
  int threads = 0;
  ProgressStyle progress = ProgressStyle::kAuto;
};

/// As schedulers want it: 75 for what another try may mend.
int FinishJob(const Result<void>& outcome) {
  const int code = Finish(outcome);
  return code == kUnavailable || code == kConflict ? static_cast<int>(kTryAgain) : code;
}

Result<void> Build(const BuildArguments& arguments) {
  CatchInterruption();
  ProgressDisplay display(arguments.progress);
  const PipelineObserver observer{
      .on_progress = [&](const PipelineProgress& progress) { display.Show(progress); },
      .should_stop = WasInterrupted};
  WAYMARK_TRY_ASSIGN(const SubmapReport report,
                     BuildSubmap(arguments.map, arguments.task, {arguments.threads}, observer));
  fmt::print("submap {}{}: {}{}\n", report.task,
             report.id ? fmt::format(" = {}", report.id->text()) : std::string(), report.verdict,
             report.was_built_before ? " (built before)" : "");
  return {};
}

}  // namespace

void RegisterBuildSubmap(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<BuildArguments>();
  CLI::App* build = app.add_subcommand("build-submap", "Builds one planned submap");
  build->footer(
      "ID is one of those that `waymark-map add MAP EXPERIENCE --plan-only` prints. Any number of\n"
      "processes may build at once; a submap that is built is not built again. A submap that is\n"
      "refused is an answer, so the exit status is 0: `waymark-map info MAP` lists it. 75 asks\n"
      "to be tried again: disk full, memory short. `waymark-map add --executor slurm` does all\n"
      "this by itself.");
  build->add_option("MAP", arguments->map, "the map directory")->required();
  build->add_option("ID", arguments->task, "of the planned submap")->required();
  build->add_option("--threads", arguments->threads, "0: all cores")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  AddProgressOption(*build, arguments->progress);
  build->callback([arguments, &exit_code] { exit_code = FinishJob(Build(*arguments)); });
}

}  // namespace waymark::mapping
