// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "content_store/tools/anchor_commands.h"

namespace waymark::content {
namespace {

using Command = Result<int> (*)(const ToolArguments&);

constexpr const char* kFooter =
    "Examples:\n"
    "  waymark-anchors anchors.db list                 rooms and how full they are\n"
    "  waymark-anchors anchors.db list lobby           the anchors of one room\n"
    "  waymark-anchors anchors.db show lobby ID        one anchor, all of it, as GeoJSON\n"
    "  waymark-anchors anchors.db query lobby --circle 47.37,8.54,100 --nearest 5\n"
    "  waymark-anchors anchors.db query --public --box 47.3,8.5,47.4,8.6\n"
    "  waymark-anchors anchors.db export > all.geojson\n"
    "  waymark-anchors postgresql://user@host/db import all.geojson\n"
    "  createdb waymark && waymark-anchors postgresql:///waymark import all.geojson\n"
    "  waymark-anchors anchors.db check                after a crash, before a backup\n"
    "  waymark-anchors anchors.db compact              gives back what superseded states take\n"
    "Exit status: 0 done, 1 refused, failed, damaged or anchors kept (the reason is printed),\n"
    "above 100 wrong usage.\n"
    "The first import or server makes the store: the file, or the tables in a database that is\n"
    "there.";

/// One subcommand that chooses what runs.
CLI::App* Add(CLI::App& app, Command& chosen, Command command, const char* name,
              const char* description) {
  CLI::App* const added = app.add_subcommand(name, description);
  added->callback([&chosen, command] { chosen = command; });
  return added;
}

void AddCommands(CLI::App& app, ToolArguments& a, Command& chosen) {
  Add(app, chosen, ListAnchors, "list", "Lists the rooms, or the anchors of one room")
      ->add_option("ROOM", a.room, "a room; without it the rooms are listed");
  auto* show = Add(app, chosen, ShowAnchor, "show", "Prints one anchor with all it has");
  show->add_option("ROOM", a.room)->required();
  show->add_option("ID", a.id, "the anchor's UUID, as list prints it")->required();

  auto* query = Add(app, chosen, QueryAnchors, "query", "Lists anchors by place and time");
  query->add_option("ROOM", a.room, "a room");
  query->add_flag("--public", a.is_public, "instead of a room: public anchors of all rooms");
  auto* circle = query->add_option("--circle", a.circle, "LATITUDE,LONGITUDE,RADIUS_M");
  circle->expected(3)->delimiter(',');
  query->add_option("--box", a.box, "SOUTH,WEST,NORTH,EAST in degrees")
      ->expected(4)
      ->delimiter(',')
      ->excludes(circle);
  query->add_option("--nearest", a.nearest, "only so many of a circle, nearest first");
  query->add_option("--since", a.since_utc_ms, "changed then or later, UTC in milliseconds");
  query->add_option("--until", a.until_utc_ms, "changed before, UTC in milliseconds");

  auto* import = Add(app, chosen, ImportAnchors, "import", "Creates the anchors of a GeoJSON");
  import->add_option("FILE", a.file, "what export wrote; - or nothing: standard input");
  import->add_option("--room", a.room, "put all into this room");
  import->add_flag("--replace", a.replaces, "anchors that differ are replaced, not kept");
  Add(app, chosen, ExportAnchors, "export", "Prints a room, or everything, as GeoJSON")
      ->add_option("ROOM", a.room, "a room; without it all");

  Add(app, chosen, CheckAnchors, "check", "Reads everything: structure, checksums, the log");
  Add(app, chosen, CompactAnchors, "compact", "Removes superseded states")
      ->add_option("--keep", a.keep_revisions, "leave so many latest revisions alone")
      ->capture_default_str();
  Add(app, chosen, MigrateAnchors, "migrate", "Upgrades a store that an earlier version wrote");
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Looks into an anchor store and tends it: the content that stays where phones put it.\n"
      "Safe while waymark-serve uses the same store.");
  app.footer(kFooter);
  app.require_subcommand(1);
  ToolArguments arguments;
  Command command = nullptr;
  app.add_option("STORE", arguments.store, "a file, or postgresql://user@host/database")
      ->required();
  AddCommands(app, arguments, command);
  CLI11_PARSE(app, argc, argv);
  const auto status = command(arguments);
  if (status) return *status;
  fmt::print(stderr, "waymark-anchors: {}\n", ToString(status.error()));
  return 1;
}

}  // namespace
}  // namespace waymark::content

int main(int argc, char** argv) { return waymark::content::Run(argc, argv); }
