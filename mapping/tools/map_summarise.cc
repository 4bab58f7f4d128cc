// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "mapping/summary/summarise_map.h"
#include "mapping/tools/map_commands.h"

namespace waymark::mapping {
namespace {

struct SummariseArguments {
  std::string map;
  std::string out;
  std::uint64_t epoch = 0;           // 0: the live one
  std::vector<std::string> submaps;  // beginnings of ids; empty: all
  double max_megabytes = 5;
  SummaryOptions options;
  Parallelism parallelism;
};

/// Leaves the submaps that were asked for. Errors: NotFound when a text begins no id.
Result<void> Select(const std::vector<std::string>& wanted, Release& release) {
  const auto is_wanted = [](const ReleasedSubmap& submap, const std::string& beginning) {
    return submap.id.text().starts_with(beginning);
  };
  for (const std::string& beginning : wanted) {
    if (std::any_of(release.submaps.begin(), release.submaps.end(),
                    [&](const auto& submap) { return is_wanted(submap, beginning); })) {
      continue;
    }
    return MakeError(ErrorCode::kNotFound, "--submap {}: no submap of epoch {} begins like that",
                     beginning, release.epoch);
  }
  std::erase_if(release.submaps, [&](const ReleasedSubmap& submap) {
    return !wanted.empty() && std::none_of(wanted.begin(), wanted.end(), [&](const auto& beginning) {
      return is_wanted(submap, beginning);
    });
  });
  return {};
}

Result<void> Summarise(const SummariseArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(arguments.map));
  WAYMARK_TRY_ASSIGN(Release release, arguments.epoch == 0
                                                ? map.LoadCurrentRelease()
                                                : map.LoadRelease(arguments.epoch));
  WAYMARK_TRY(Select(arguments.submaps, release));
  SummaryOptions options = arguments.options;
  options.max_bytes = static_cast<std::size_t>(1e6 * arguments.max_megabytes);
  WAYMARK_TRY_ASSIGN(const auto submaps, SummariseMap(map, release, arguments.out, options,
                                                      arguments.parallelism));
  fmt::print("{:32}  {:>8} {:>8}  {:>9} {:>9}  {:>11} {:>11}\n", "submap", "MB", "now", "landmarks",
             "now", "descriptors", "now");
  for (const SummarisedSubmap& submap : submaps) {
    fmt::print("{:32}  {:8.2f} {:8.2f}  {:9} {:9}  {:11} {:11}\n", submap.before.text(),
               1e-6 * static_cast<double>(submap.bytes_before),
               1e-6 * static_cast<double>(submap.bytes_after), submap.landmarks_before,
               submap.landmarks_after, submap.descriptors_before, submap.descriptors_after);
  }
  fmt::print("epoch {} is live in {}\n", release.epoch, arguments.out);
  return {};
}

}  // namespace

void RegisterSummarise(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SummariseArguments>();
  CLI::App* summarise =
      app.add_subcommand("summarise", "Makes a small map to localise in from a large one");
  summarise->footer(
      "Keeps in every submap the landmarks that matter most for localising, so that every image\n"
      "still sees some in all its parts, and a few descriptors of each. The result is a map like\n"
      "any other: serve it, localise in it. It is no map to add drives to.\n"
      "Examples:\n"
      "  waymark-map summarise MAP --out SMALL --max-mb 2\n"
      "  waymark-map summarise MAP --out TILE --submap 0f3c --max-mb 0.95\n"
      "The second is a tile for a phone: waymark-localise TILE PHOTOS --out poses.csv needs nothing\n"
      "else, and no network.");
  summarise->add_option("MAP", arguments->map, "the map directory")->required();
  summarise->add_option("--out", arguments->out, "folder of the small map; made here")->required();
  summarise->add_option("--epoch", arguments->epoch, "which release; default: the live one");
  summarise->add_option("--submap", arguments->submaps,
                        "the beginning of a submap's id, several times for several; default: all");
  summarise->add_option("--max-mb", arguments->max_megabytes, "of a submap, in 10^6 bytes")
      ->check(CLI::Range(0.1, 10000.0))
      ->capture_default_str();
  summarise
      ->add_option("--descriptors", arguments->options.choice.descriptors.max_count,
                   "of one landmark, at most")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  summarise->add_option("--threads", arguments->parallelism.threads, "0: all cores");
  summarise->callback([arguments, &exit_code] { exit_code = Finish(Summarise(*arguments)); });
}

}  // namespace waymark::mapping
