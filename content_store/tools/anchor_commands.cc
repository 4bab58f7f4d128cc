// SPDX-License-Identifier: Apache-2.0
#include "content_store/tools/anchor_commands.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>

#include "content_store/anchor_store.h"
#include "content_store/geo_json.h"
#include "content_store/store_admin.h"
#include "content_store/store_check.h"
#include "content_store/transfer.h"

namespace waymark::content {
namespace {

/// Text of strangers for a terminal: control characters would be obeyed.
std::string Printable(std::string text) {
  for (char& c : text) c = (c >= 0 && c < ' ') || c == 127 ? '?' : c;
  return text;
}

Result<std::unique_ptr<AnchorStore>> OpenForReading(const ToolArguments& arguments) {
  return OpenStore(arguments.store, {.mode = OpenMode::kExisting, .migration = Migration::kRefuse});
}

std::optional<RoomId> RoomOf(const ToolArguments& arguments) {
  return arguments.room.empty() ? std::nullopt : std::optional(RoomId(arguments.room));
}

void PrintTableHead() {
  fmt::print("{:36}  {:>10}  {:>12}  {:>13}  kind\n", "id", "revision", "latitude", "longitude");
}

void PrintRow(const AnchorRecord& anchor) {
  fmt::print("{:36}  {:10}  {:12.7f}  {:13.7f}  {}\n", anchor.id.text(), anchor.revision,
             anchor.place.latitude.degrees(), anchor.place.longitude.degrees(),
             Printable(anchor.kind));
}

GeoPoint PlaceOf(double latitude_deg, double longitude_deg) {
  return {.latitude = Angle::Degrees(latitude_deg),
          .longitude = Angle::Degrees(longitude_deg),
          .ellipsoid_height_m = 0};
}

Result<AnchorQuery> MakeQuery(const ToolArguments& arguments) {
  AnchorQuery query{.room = RoomOf(arguments), .limit = 200};
  if (arguments.is_public == query.room.has_value()) {
    return MakeError(ErrorCode::kInvalidArgument, "query: expected either a room or --public");
  }
  if (!arguments.circle.empty()) {
    query.area = GeoCircle{PlaceOf(arguments.circle[0], arguments.circle[1]), arguments.circle[2]};
  }
  if (!arguments.box.empty()) {
    const auto degree = [&](std::size_t i) { return Angle::Degrees(arguments.box[i]); };
    query.area = GeoBox{degree(0), degree(1), degree(2), degree(3)};
  }
  if (arguments.since_utc_ms || arguments.until_utc_ms) {
    query.changed.emplace();
    if (arguments.since_utc_ms) query.changed->from_utc_ms = *arguments.since_utc_ms;
    if (arguments.until_utc_ms) query.changed->until_utc_ms = *arguments.until_utc_ms;
  }
  return query;
}

}  // namespace

Result<int> ListAnchors(const ToolArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const auto store, OpenForReading(arguments));
  if (arguments.room.empty()) {
    WAYMARK_TRY_ASSIGN(const auto rooms, store->ListRooms());
    fmt::print("{:>8}  {:>10}  room\n", "anchors", "revision");
    for (const RoomSummary& room : rooms) {
      fmt::print("{:8}  {:10}  {}\n", room.anchors, room.revision, Printable(room.room.text()));
    }
    return 0;
  }
  WAYMARK_TRY_ASSIGN(const auto snapshot, store->LoadRoom(RoomId(arguments.room)));
  PrintTableHead();
  for (const AnchorRecord& anchor : snapshot.anchors) PrintRow(anchor);
  return 0;
}

Result<int> ShowAnchor(const ToolArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const auto store, OpenForReading(arguments));
  WAYMARK_TRY_ASSIGN(const auto anchor,
                     store->Find(RoomId(arguments.room), AnchorId(arguments.id)));
  if (!anchor) {
    return MakeError(ErrorCode::kNotFound, "{}: no anchor {} in room {}", arguments.store,
                     arguments.id, arguments.room);
  }
  fmt::print("{}\n", EncodeGeoJson(*anchor));
  return 0;
}

Result<int> QueryAnchors(const ToolArguments& arguments) {
  WAYMARK_TRY_ASSIGN(AnchorQuery query, MakeQuery(arguments));
  WAYMARK_TRY_ASSIGN(const auto store, OpenForReading(arguments));
  if (arguments.nearest > 0) {
    const auto* circle = std::get_if<GeoCircle>(&query.area);
    if (circle == nullptr || !query.room) {
      return MakeError(ErrorCode::kInvalidArgument, "--nearest: expected a room and --circle");
    }
    WAYMARK_TRY_ASSIGN(const auto near, store->FindNear(*query.room, circle->centre,
                                                        circle->radius_m, arguments.nearest));
    PrintTableHead();
    for (const AnchorRecord& anchor : near) PrintRow(anchor);
    return 0;
  }
  PrintTableHead();
  do {
    WAYMARK_TRY_ASSIGN(const auto page, store->Query(query));
    for (const AnchorRecord& anchor : page.anchors) PrintRow(anchor);
    query.after = page.next;
  } while (query.after);
  return 0;
}

Result<int> ImportAnchors(const ToolArguments& arguments) {
  std::ifstream file;
  if (arguments.file != "-") {
    file.open(arguments.file);
    if (!file) {
      return MakeError(ErrorCode::kNotFound, "{}: cannot read: {}", arguments.file,
                       std::strerror(errno));
    }
  }
  WAYMARK_TRY_ASSIGN(const auto store, OpenStore(arguments.store, {.limits = StoreLimits::None()}));
  WAYMARK_TRY_ASSIGN(const auto report,
                     ImportGeoJson(*store, arguments.file == "-" ? std::cin : file,
                                   {.room = RoomOf(arguments),
                                    .on_difference = arguments.replaces ? OnDifference::kReplace
                                                                        : OnDifference::kKeep}));
  fmt::print("{} created, {} unchanged, {} replaced, {} kept as they were\n", report.created,
             report.unchanged, report.replaced, report.kept);
  for (const std::string& example : report.examples) fmt::print("kept: {}\n", Printable(example));
  return report.kept == 0 ? 0 : 1;
}

Result<int> ExportAnchors(const ToolArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const auto store, OpenForReading(arguments));
  WAYMARK_TRY_ASSIGN(const auto report, ExportGeoJson(*store, RoomOf(arguments), std::cout));
  fmt::print(stderr, "{} anchors as of revision {}\n", report.anchors, report.revision);
  return 0;
}

Result<int> CheckAnchors(const ToolArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const StoreCheck check, CheckStore(arguments.store));
  fmt::print("revision {}: {} anchors, {} deleted, {} superseded states", check.revision,
             check.anchors, check.deleted, check.superseded);
  if (check.compacted_through > 0) {
    fmt::print("; compacted through revision {}", check.compacted_through);
  }
  fmt::print("\n");
  for (const std::string& problem : check.problems) {
    fmt::print("damaged: {}\n", Printable(problem));
  }
  if (check.problems.empty()) fmt::print("sound\n");
  return check.problems.empty() ? 0 : 1;
}

Result<int> CompactAnchors(const ToolArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const auto report, CompactStore(arguments.store, arguments.keep_revisions));
  fmt::print("{} states before, {} after; compacted through revision {}\n", report.states_before,
             report.states_after, report.compacted_through);
  return 0;
}

Result<int> MigrateAnchors(const ToolArguments& arguments) {
  WAYMARK_TRY_ASSIGN(const bool was_needed, MigrateStore(arguments.store));
  fmt::print("{}\n", was_needed ? "upgraded to the present schema" : "nothing to do");
  return 0;
}

}  // namespace waymark::content
