// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "mapping/pipeline/pruning.h"
#include "mapping/tools/map_commands.h"

namespace waymark::mapping {
namespace {

struct PruneArguments {
  std::string map;
  std::size_t keep = PruneRequest{}.keep;
  bool is_rehearsal = false;
};

Result<void> Prune(const PruneArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const PruneReport report, PruneMap({.map_folder = arguments.map,
                                                         .keep = arguments.keep,
                                                         .is_rehearsal = arguments.is_rehearsal}));
  if (!report.releases.empty()) {
    fmt::print("epochs: {}\n", fmt::join(report.releases, ", "));
  }
  for (const SubmapId& id : report.submaps) fmt::print("submap {}\n", id.text());
  for (const ExperienceId& id : report.experiences) fmt::print("experience {}\n", id.text());
  fmt::print("{} {} releases, {} submaps, {} experiences, {} other files, {:.1f} MB\n",
             arguments.is_rehearsal ? "would delete" : "deleted", report.releases.size(),
             report.submaps.size(), report.experiences.size(), report.other_files,
             static_cast<double>(report.bytes) / 1e6);
  return {};
}

}  // namespace

void RegisterPrune(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<PruneArguments>();
  CLI::App* prune = app.add_subcommand("prune", "Deletes what no kept release needs");
  prune->footer(
      "Keeps the live release and the newest ones, with their submaps and experiences. What goes\n"
      "cannot be rolled back to. A removed experience goes once no kept release holds a submap of\n"
      "it, and can then be added again, even with other content. Servers are not disturbed: they\n"
      "hold the live release. Killed in between, run it again.");
  prune->add_option("MAP", arguments->map, "the map directory")->required();
  prune->add_option("--keep", arguments->keep, "newest releases that stay beside the live one")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  prune->add_flag("--dry-run", arguments->is_rehearsal, "say what would go, and delete nothing");
  prune->callback([arguments, &exit_code] { exit_code = Finish(Prune(*arguments)); });
}

}  // namespace waymark::mapping
