// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <string>

#include "mapping/tools/map_commands.h"

int main(int argc, char** argv) {
  using namespace waymark::mapping;
  CLI::App app("Builds maps from recordings of cameras, GNSS and IMU, and looks after them.");
  app.name("waymark-map");
  app.require_subcommand(1);
  app.footer(
      "Examples:\n"
      "  waymark-map import photos PHOTOS --out street   phone photos become an experience\n"
      "  waymark-map add MAP street drive1 drive2        makes MAP, or adds to it\n"
      "  waymark-map info MAP                            what is in it, what was refused and why\n"
      "  waymark-map report MAP                          how building went, with all figures\n"
      "  waymark-map remove MAP --experience drive1      takes it out again\n"
      "  waymark-map diff MAP                            what moved with the live release\n"
      "  waymark-map draw MAP --out map.png              submaps and images from above\n"
      "  waymark-map export MAP --format colmap --out model\n"
      "  waymark-map summarise MAP --out SMALL           a map to localise in, 5 MB a submap\n"
      "  waymark-map rollback MAP                        the release before is live again\n"
      "`waymark-map COMMAND --help` explains one command.\n"
      "Exit status: 0 done, 1 nothing entered the map, 64 wrong usage, 65 wrong data, 66 an input\n"
      "is missing, 69 disk or solver failed, 73 another writer or name clash, 75 (build-submap) "
      "try\n"
      "again, 130 interrupted.");
  int exit_code = kDone;
  RegisterAdd(app, exit_code);
  RegisterBuildSubmap(app, exit_code);
  RegisterInfo(app, exit_code);
  RegisterReport(app, exit_code);
  RegisterRemove(app, exit_code);
  RegisterPrune(app, exit_code);
  RegisterReleases(app, exit_code);
  RegisterDiff(app, exit_code);
  RegisterDraw(app, exit_code);
  RegisterSummarise(app, exit_code);
  RegisterImport(app, exit_code);
  RegisterExport(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? static_cast<int>(kDone) : static_cast<int>(kBadUsage);
  }
  return exit_code;
}
