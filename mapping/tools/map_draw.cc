// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "mapping/base/file.h"
#include "mapping/tools/map_commands.h"
#include "mapping/tools/map_picture.h"
#include "mapping/tools/open_release.h"

namespace waymark::mapping {
namespace {

struct DrawArguments {
  std::string map;
  std::string out;
  std::uint64_t epoch = 0;  // 0: the live one
  int side_px = 1600;
};

Result<void> Draw(const DrawArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const OpenRelease open, LoadRelease(arguments.map, arguments.epoch));
  std::vector<DrawnSubmap> submaps;
  for (std::size_t i = 0; i < open.views.size(); ++i) {
    const ReleasedSubmap& submap = open.release.submaps[i];
    submaps.push_back({{open.views[i], submap.map_from_submap}, submap.centre, submap.radius_m});
  }
  WAYMARK_TRY_ASSIGN(const auto png, DrawMap(submaps, arguments.side_px));
  WAYMARK_TRY(StoreFileAtomically(arguments.out, png));
  fmt::print("{}: epoch {}, {} submaps\n", arguments.out, open.release.epoch, submaps.size());
  return {};
}

}  // namespace

void RegisterDraw(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<DrawArguments>();
  CLI::App* draw = app.add_subcommand("draw", "Draws a release from above as a PNG");
  draw->footer(
      "Example: waymark-map draw MAP --out map.png\n"
      "Grey: landmarks. Each submap has a colour: its circle, dots for the images it owns, rings\n"
      "for those it borrowed, by which submaps are joined.");
  draw->add_option("MAP", arguments->map, "the map directory")->required();
  draw->add_option("--out", arguments->out, "the picture to write")->required();
  draw->add_option("--epoch", arguments->epoch, "of the release; the live one when not given");
  draw->add_option("--side", arguments->side_px, "longer side of the picture, pixels")
      ->capture_default_str()
      ->check(CLI::Range(200, 20000));
  draw->callback([arguments, &exit_code] { exit_code = Finish(Draw(*arguments)); });
}

}  // namespace waymark::mapping
