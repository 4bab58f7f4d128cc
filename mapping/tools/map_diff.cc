// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mapping/geometry/angle.h"
#include "mapping/store/map_directory.h"
#include "mapping/store/release_diff.h"
#include "mapping/tools/map_commands.h"
#include "mapping/tools/movement.h"

namespace waymark::mapping {
namespace {

struct DiffArguments {
  std::string map;
  std::vector<std::uint64_t> epochs;
  std::size_t rows = 20;
  bool as_json = false;
};

/// None: the live release since its parent. One: that release since its parent.
Result<std::pair<Release, Release>> LoadBoth(const MapDirectory& map,
                                             const std::vector<std::uint64_t>& epochs) {
  WAYMARK_TRY_ASSIGN(Release to,
                     epochs.empty() ? map.LoadCurrentRelease() : map.LoadRelease(epochs.back()));
  if (epochs.size() == 2) {
    WAYMARK_TRY_ASSIGN(Release from, map.LoadRelease(epochs.front()));
    return std::pair(std::move(from), std::move(to));
  }
  if (!to.parent_epoch) {
    return MakeError(ErrorCode::kNotFound, "{}: epoch {} is the first; there is none before it",
                     map.folder().string(), to.epoch);
  }
  WAYMARK_TRY_ASSIGN(Release from, map.LoadRelease(*to.parent_epoch));
  return std::pair(std::move(from), std::move(to));
}

void PrintTable(const ReleaseDiff& diff, std::size_t rows) {
  fmt::print("from epoch {} to {}: {} in both, {} added, {} removed\n", diff.from_epoch,
             diff.to_epoch, diff.moved.size(), diff.added.size(), diff.removed.size());
  if (!diff.moved.empty()) {
    fmt::print("median {}\nworst  {}\n", DescribeDisplacement(diff.median),
               DescribeDisplacement(diff.worst));
    fmt::print("{:32}  {:>10}  {:>12}  {:>10}\n", "submap, moved most first", "moved, cm",
               "turned, deg", "scale");
  }
  const std::size_t shown = rows == 0 ? diff.moved.size() : std::min(rows, diff.moved.size());
  for (std::size_t i = 0; i < shown; ++i) {
    const Displacement& d = diff.moved[i].displacement;
    fmt::print("{:32}  {:>10.2f}  {:>12.4f}  {:>10.6f}\n", diff.moved[i].id.text(),
               100 * d.translation_m, Angle::Radians(d.rotation_rad).degrees(), d.scale_ratio);
  }
  if (shown < diff.moved.size()) {
    fmt::print("and {} that moved less; --rows 0 shows all\n", diff.moved.size() - shown);
  }
  for (const SubmapId& id : diff.added) fmt::print("{:32}       added\n", id.text());
  for (const SubmapId& id : diff.removed) fmt::print("{:32}     removed\n", id.text());
}

Result<void> Diff(const DiffArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(arguments.map));
  WAYMARK_TRY_ASSIGN(const auto releases, LoadBoth(map, arguments.epochs));
  const ReleaseDiff diff = CompareReleases(releases.first, releases.second);
  if (arguments.as_json) {
    fmt::print("{}", EncodeReleaseDiff(diff));
  } else {
    PrintTable(diff, arguments.rows);
  }
  return {};
}

}  // namespace

void RegisterDiff(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<DiffArguments>();
  CLI::App* diff = app.add_subcommand("diff", "Says what moved from one release to another");
  diff->footer(
      "Examples:\n"
      "  waymark-map diff MAP              the live release since the one it was made from\n"
      "  waymark-map diff MAP 7            epoch 7 since the one it was made from\n"
      "  waymark-map diff MAP 3 7 --json   from epoch 3 to 7, for programs\n"
      "Movement is that of a submap's centre; turning is about any axis.");
  diff->add_option("MAP", arguments->map, "the map directory")->required();
  diff->add_option("EPOCH", arguments->epochs, "one, or from and to")->expected(0, 2);
  diff->add_option("--rows", arguments->rows, "of submaps in both, moved most first; 0: all")
      ->capture_default_str();
  diff->add_flag("--json", arguments->as_json, "everything, as one JSON document");
  diff->callback([arguments, &exit_code] { exit_code = Finish(Diff(*arguments)); });
}

}  // namespace waymark::mapping
