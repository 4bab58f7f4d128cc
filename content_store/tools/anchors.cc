// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

#include "content_store/anchor_store.h"
#include "content_store/geo_json.h"
#include "content_store/store_check.h"

namespace waymark::content {
namespace {

struct Arguments {
  std::string store, room, id;
};

/// Text of strangers for a terminal: control characters would be obeyed.
std::string Printable(std::string text) {
  for (char& c : text) c = (c >= 0 && c < ' ') || c == 127 ? '?' : c;
  return text;
}

Result<int> List(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(const auto store,
                     OpenSqliteStore(arguments.store, {.mode = OpenMode::kExisting}));
  if (arguments.room.empty()) {
    WAYMARK_TRY_ASSIGN(const auto rooms, store->ListRooms());
    fmt::print("{:>8}  {:>10}  room\n", "anchors", "revision");
    for (const RoomSummary& room : rooms) {
      fmt::print("{:8}  {:10}  {}\n", room.anchors, room.revision, Printable(room.room.text()));
    }
    return 0;
  }
  WAYMARK_TRY_ASSIGN(const auto snapshot, store->LoadRoom(RoomId(arguments.room)));
  fmt::print("{:36}  {:>10}  {:>12}  {:>13}  kind\n", "id", "revision", "latitude", "longitude");
  for (const AnchorRecord& anchor : snapshot.anchors) {
    fmt::print("{:36}  {:10}  {:12.7f}  {:13.7f}  {}\n", anchor.id.text(), anchor.revision,
               anchor.place.latitude.degrees(), anchor.place.longitude.degrees(),
               Printable(anchor.kind));
  }
  return 0;
}

Result<int> Show(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(const auto store,
                     OpenSqliteStore(arguments.store, {.mode = OpenMode::kExisting}));
  WAYMARK_TRY_ASSIGN(const auto anchor,
                     store->Find(RoomId(arguments.room), AnchorId(arguments.id)));
  if (!anchor) {
    return MakeError(ErrorCode::kNotFound, "{}: no anchor {} in room {}", arguments.store,
                     arguments.id, arguments.room);
  }
  fmt::print("{}\n", EncodeGeoJson(*anchor));
  return 0;
}

Result<int> Export(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(const auto store,
                     OpenSqliteStore(arguments.store, {.mode = OpenMode::kExisting}));
  WAYMARK_TRY_ASSIGN(const auto snapshot, store->LoadRoom(RoomId(arguments.room)));
  fmt::print("{}\n", EncodeGeoJson(snapshot));
  return 0;
}

Result<int> Check(const Arguments& arguments) {
  WAYMARK_TRY_ASSIGN(const StoreCheck check, CheckSqliteStore(arguments.store));
  fmt::print("revision {}: {} anchors, {} deleted, {} superseded states\n", check.revision,
             check.anchors, check.deleted, check.superseded);
  for (const std::string& problem : check.problems) fmt::print("damaged: {}\n", problem);
  if (check.problems.empty()) fmt::print("sound\n");
  return check.problems.empty() ? 0 : 1;
}

int Run(int argc, char** argv) {
  CLI::App app(
      "Looks into an anchor store: the content that stays where phones put it.\n"
      "Safe while waymark-serve writes to the same file; nothing here changes an anchor.");
  app.footer(
      "Examples:\n"
      "  waymark-anchors anchors.db list                 rooms and how full they are\n"
      "  waymark-anchors anchors.db list lobby           the anchors of one room\n"
      "  waymark-anchors anchors.db show lobby ID        one anchor, all of it, as GeoJSON\n"
      "  waymark-anchors anchors.db export lobby > lobby.geojson\n"
      "  waymark-anchors anchors.db check                after a crash, before a backup\n"
      "Exit status: 0 done, 1 refused, failed or damaged (the reason is printed),\nabove 100 wrong "
      "usage.");
  app.require_subcommand(1);
  Arguments arguments;
  app.add_option("STORE", arguments.store, "the store's file, for example anchors.db")->required();
  Result<int> (*command)(const Arguments&) = nullptr;
  auto* list = app.add_subcommand("list", "Lists the rooms, or the anchors of one room");
  list->add_option("ROOM", arguments.room, "a room; without it the rooms are listed");
  list->callback([&] { command = List; });
  auto* show = app.add_subcommand("show", "Prints one anchor with pose, attachments and payload");
  show->add_option("ROOM", arguments.room)->required();
  show->add_option("ID", arguments.id, "the anchor's UUID, as list prints it")->required();
  show->callback([&] { command = Show; });
  auto* geo = app.add_subcommand("export", "Prints a room as GeoJSON, for any map viewer");
  geo->add_option("ROOM", arguments.room)->required();
  geo->callback([&] { command = Export; });
  auto* check = app.add_subcommand("check", "Reads everything: page structure, checksums, the log");
  check->callback([&] { command = Check; });
  CLI11_PARSE(app, argc, argv);
  const auto status = command(arguments);
  if (status) return *status;
  fmt::print(stderr, "waymark-anchors: {}\n", ToString(status.error()));
  return 1;
}

}  // namespace
}  // namespace waymark::content

int main(int argc, char** argv) { return waymark::content::Run(argc, argv); }
