// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/sql_tables.h"

#include "content_store/internal/sql_numbers.h"

namespace waymark::content::internal {
namespace {

using soci::into;
using soci::use;

std::vector<std::uint64_t> FetchRevisions(soci::statement& statement, const long long& revision) {
  std::vector<std::uint64_t> revisions;
  statement.execute();
  while (statement.fetch()) revisions.push_back(static_cast<std::uint64_t>(revision));
  return revisions;
}

}  // namespace

Compaction SqlTables::LoadCompaction() {
  long long through = 0, rows = 0;
  sql() << "SELECT coalesce(max(value) FILTER (WHERE name = 'compacted_through'), 0), "
           "coalesce(max(value) FILTER (WHERE name = 'compacted_rows'), 0) FROM "
        << Table("facts"),
      into(through), into(rows);
  return {static_cast<std::uint64_t>(through), static_cast<std::uint64_t>(rows)};
}

std::vector<std::uint64_t> SqlTables::ListRoom(const RoomId& room) {
  long long revision = 0;
  const std::string name = room.text();
  soci::statement list = (sql().prepare << "SELECT revision FROM " << Table("places")
                                        << " WHERE room = :room AND cell IS NOT NULL ORDER BY id",
                          use(name), into(revision));
  return FetchRevisions(list, revision);
}

std::vector<std::uint64_t> SqlTables::FindReplaced(const std::optional<RoomId>& room,
                                                   std::uint64_t since, std::size_t limit) {
  long long revision = 0;
  const long long then = Clamp(since), most = Clamp(limit);
  const std::string name = room ? room->text() : "";
  const char* const where = room ? "room = :room" : "CAST(:room AS text) = ''";
  soci::statement replaced =
      (sql().prepare << "SELECT previous FROM " << Table("states") << " WHERE " << where
                     << " AND revision > :since AND previous BETWEEN 1 AND :then LIMIT :limit",
       use(name), use(then), use(then), use(most), into(revision));
  return FetchRevisions(replaced, revision);
}

std::vector<RoomSummary> SqlTables::ListRooms() {
  std::string room;
  long long anchors = 0, revision = 0;
  soci::statement rooms = (sql().prepare << "SELECT room, count(cell), max(revision) FROM "
                                         << Table("places") << " GROUP BY room ORDER BY room",
                           into(room), into(anchors), into(revision));
  std::vector<RoomSummary> summaries;
  rooms.execute();
  while (rooms.fetch()) {
    summaries.push_back(
        {RoomId(room), static_cast<std::size_t>(anchors), static_cast<std::uint64_t>(revision)});
  }
  return summaries;
}

std::vector<PlaceRow> SqlTables::FindExpired(std::int64_t now_utc_ms, std::size_t limit) {
  std::string room, id;
  long long revision = 0;
  const long long now = now_utc_ms, most = Clamp(limit);
  soci::statement due =
      (sql().prepare
           << "SELECT room, id, revision FROM " << Table("places")
           << " WHERE expires IS NOT NULL AND expires <= :now ORDER BY expires LIMIT :limit",
       use(now), use(most), into(room), into(id), into(revision));
  std::vector<PlaceRow> places;
  due.execute();
  while (due.fetch()) {
    places.push_back(
        {.key = {RoomId(room), AnchorId(id)}, .revision = static_cast<std::uint64_t>(revision)});
  }
  return places;
}

std::vector<PlaceRow> SqlTables::ListPlaces(const std::optional<AnchorKey>& after,
                                            std::size_t limit) {
  const std::string after_room = after ? after->room.text() : "";
  const std::string after_id = after ? after->id.text() : "";
  const long long most = Clamp(limit);
  std::string room, id;
  long long revision = 0, values[3] = {};
  int is_public = 0;
  soci::indicator has[3] = {};
  soci::statement list =
      (sql().prepare << "SELECT room, id, revision, cell, changed, expires, CAST(is_public AS "
                        "integer) FROM "
                     << Table("places")
                     << " WHERE (room, id) > (:room, :id) ORDER BY room, id LIMIT :limit",
       use(after_room), use(after_id), use(most), into(room), into(id), into(revision),
       into(values[0], has[0]), into(values[1], has[1]), into(values[2], has[2]), into(is_public));
  const auto get = [&](int i) {
    return has[i] == soci::i_ok ? std::optional<std::int64_t>(values[i]) : std::nullopt;
  };
  std::vector<PlaceRow> places;
  list.execute();
  while (list.fetch()) {
    places.push_back({{RoomId(room), AnchorId(id)},
                      static_cast<std::uint64_t>(revision),
                      get(0),
                      get(1),
                      get(2),
                      is_public != 0});
  }
  return places;
}

std::map<OwnerKey, Usage> SqlTables::ListUsage() {
  std::map<OwnerKey, Usage> usage;
  std::string room, owner;
  long long anchors = 0, bytes = 0;
  soci::statement list =
      (sql().prepare << "SELECT room, owner, anchors, bytes FROM " << Table("usage"), into(room),
       into(owner), into(anchors), into(bytes));
  list.execute();
  while (list.fetch()) usage[{room, owner}] = {anchors, bytes};
  return usage;
}

std::uint64_t SqlTables::CountLog(std::uint64_t after, std::uint64_t through) {
  long long rows = 0;
  const long long first = Clamp(after), last = Clamp(through);
  sql() << "SELECT count(*) FROM " << Table("states")
        << " WHERE revision > :first AND revision <= :last",
      use(first), use(last), into(rows);
  return static_cast<std::uint64_t>(rows);
}

void SqlTables::RemoveSuperseded(std::uint64_t after, std::uint64_t through) {
  const long long first = Clamp(after), last = Clamp(through);
  sql() << "DELETE FROM " << Table("states")
        << " AS s WHERE s.revision > :first AND s.revision <= :last AND NOT EXISTS (SELECT 1 FROM "
        << Table("places")
        << " AS p WHERE p.room = s.room AND p.id = s.id AND p.revision = s.revision)",
      use(first), use(last);
}

void SqlTables::StoreCompaction(const Compaction& compaction) {
  const long long through = Clamp(compaction.through), rows = Clamp(compaction.rows);
  sql() << "INSERT INTO " << Table("facts")
        << " (name, value) VALUES ('compacted_through', :through), "
           "('compacted_rows', :rows) ON CONFLICT (name) DO UPDATE SET value = excluded.value",
      use(through), use(rows);
}

}  // namespace waymark::content::internal
