// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>

#include "mapping/store/map_directory.h"
#include "mapping/tools/map_commands.h"

namespace waymark::mapping {
namespace {

/// One line about a release: what it holds and how far it moved what was there.
void PrintRelease(const Release& release, bool is_live) {
  double moved_m = 0;
  double overlap_rms_m = 0;
  for (const ReleasedSubmap& submap : release.submaps) {
    overlap_rms_m = std::max(overlap_rms_m, submap.overlap_rms_m);
    if (submap.displacement) moved_m = std::max(moved_m, submap.displacement->translation_m);
  }
  fmt::print("{} epoch {}, {}, {} submaps, worst overlap {:.3f} m rms", is_live ? "*" : " ",
             release.epoch, release.created_utc, release.submaps.size(), overlap_rms_m);
  if (release.parent_epoch) {
    fmt::print(", moved submaps of epoch {} by up to {:.3f} m", *release.parent_epoch, moved_m);
  }
  fmt::print("\n");
}

Result<void> List(const std::string& folder) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(folder));
  WAYMARK_TRY_ASSIGN(const auto current, map.LoadCurrentEpoch());
  WAYMARK_TRY_ASSIGN(const auto epochs, map.ListReleaseEpochs());
  if (epochs.empty()) fmt::print("no release yet\n");
  for (const std::uint64_t epoch : epochs) {
    WAYMARK_TRY_ASSIGN(const Release release, map.LoadRelease(epoch));
    PrintRelease(release, current == epoch);
  }
  return {};
}

Result<void> Deploy(const std::string& folder, std::uint64_t epoch) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(folder));
  WAYMARK_TRY_ASSIGN(const FileLock lock, map.LockForWriting());
  WAYMARK_TRY(map.Deploy(epoch));
  fmt::print("epoch {} is live\n", epoch);
  return {};
}

Result<void> Rollback(const std::string& folder) {
  WAYMARK_TRY_ASSIGN(const MapDirectory map, MapDirectory::Open(folder));
  WAYMARK_TRY_ASSIGN(const Release live, map.LoadCurrentRelease());
  if (!live.parent_epoch) {
    return MakeError(ErrorCode::kNotFound, "{}: epoch {} is the first; there is none to go back to",
                     folder, live.epoch);
  }
  WAYMARK_TRY_ASSIGN(const auto epochs, map.ListReleaseEpochs());
  if (std::ranges::find(epochs, *live.parent_epoch) == epochs.end()) {
    return MakeError(ErrorCode::kNotFound,
                     "{}: epoch {}, which the live epoch {} was made from, has been pruned; "
                     "`waymark-map releases` lists those that are there",
                     folder, *live.parent_epoch, live.epoch);
  }
  return Deploy(folder, *live.parent_epoch);
}

struct ReleaseArguments {
  std::string map;
  std::uint64_t epoch = 0;
};

}  // namespace

void RegisterReleases(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ReleaseArguments>();
  CLI::App* releases = app.add_subcommand("releases", "Lists the releases of a map");
  releases->footer(
      "The live release has a star. Releases are never changed; `waymark-map prune` deletes old "
      "ones.");
  releases->add_option("MAP", arguments->map, "the map directory")->required();
  releases->callback([arguments, &exit_code] { exit_code = Finish(List(arguments->map)); });

  CLI::App* deploy = app.add_subcommand("deploy", "Makes a release the live one");
  deploy->footer("Example: waymark-map deploy MAP 3. Servers that watch the map follow.");
  deploy->add_option("MAP", arguments->map, "the map directory")->required();
  deploy->add_option("EPOCH", arguments->epoch, "of the release")->required();
  deploy->callback(
      [arguments, &exit_code] { exit_code = Finish(Deploy(arguments->map, arguments->epoch)); });

  CLI::App* rollback = app.add_subcommand("rollback", "Makes the release before the live one live");
  rollback->footer("Goes back to the release that the live one was made from.");
  rollback->add_option("MAP", arguments->map, "the map directory")->required();
  rollback->callback([arguments, &exit_code] { exit_code = Finish(Rollback(arguments->map)); });
}

}  // namespace waymark::mapping
