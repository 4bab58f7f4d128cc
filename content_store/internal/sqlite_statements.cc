// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/sqlite_statements.h"

#include "content_store/internal/sql_numbers.h"

namespace waymark::content::internal {

using soci::into;
using soci::use;

SqliteStatements::SqliteStatements(soci::session& sql)
    : latest_(
          (sql.prepare << "SELECT coalesce(max(revision), 0) FROM states", into(row_revision_))),
      find_((sql.prepare << "SELECT p.revision, s.previous, p.room, p.id, s.state, s.checksum FROM "
                            "places p LEFT JOIN states s ON s.revision = p.revision WHERE p.room = "
                            ":room AND p.id = :id",
             use(room_), use(id_), into(row_revision_), into(row_previous_, row_presence_[0]),
             into(row_room_), into(row_id_), into(row_state_, row_presence_[1]),
             into(row_checksum_, row_presence_[2]))),
      load_(
          (sql.prepare << "SELECT revision, previous, room, id, state, checksum FROM states WHERE "
                          "revision = :revision",
           use(revision_), into(row_revision_), into(row_previous_), into(row_room_), into(row_id_),
           into(row_state_), into(row_checksum_))),
      by_cell_((sql.prepare << "SELECT cell, revision FROM places WHERE room = :room AND cell "
                               "BETWEEN :first AND :last AND (cell, revision) > (:key, :revision) "
                               "AND revision <= :newest ORDER BY cell, revision LIMIT :limit",
                use(room_), use(first_), use(last_), use(key_), use(revision_), use(newest_),
                use(limit_), into(row_key_), into(row_revision_))),
      by_change_((sql.prepare << "SELECT changed, revision FROM places WHERE room = :room AND "
                                 "changed BETWEEN :first AND :last AND (changed, revision) > "
                                 "(:key, :revision) AND revision <= :newest ORDER BY changed, "
                                 "revision LIMIT :limit",
                  use(room_), use(first_), use(last_), use(key_), use(revision_), use(newest_),
                  use(limit_), into(row_key_), into(row_revision_))),
      public_by_cell_((sql.prepare << "SELECT cell, revision FROM places WHERE is_public = 1 AND "
                                      "cell BETWEEN :first AND :last AND (cell, revision) > (:key, "
                                      ":revision) AND revision <= :newest ORDER BY cell, revision "
                                      "LIMIT :limit",
                       use(first_), use(last_), use(key_), use(revision_), use(newest_),
                       use(limit_), into(row_key_), into(row_revision_))),
      log_((sql.prepare << "SELECT revision, previous, room, id, state, checksum FROM states WHERE "
                           "revision > :revision ORDER BY revision LIMIT :limit",
            use(revision_), use(limit_), into(row_revision_), into(row_previous_), into(row_room_),
            into(row_id_), into(row_state_), into(row_checksum_))),
      room_log_((sql.prepare << "SELECT revision, previous, room, id, state, checksum FROM states "
                                "WHERE room = :room AND revision > :revision ORDER BY revision "
                                "LIMIT :limit",
                 use(room_), use(revision_), use(limit_), into(row_revision_), into(row_previous_),
                 into(row_room_), into(row_id_), into(row_state_), into(row_checksum_))),
      append_((sql.prepare << "INSERT INTO states (revision, previous, room, id, state, checksum) "
                              "VALUES (:revision, :previous, :room, :id, CAST(:state AS BLOB), "
                              ":checksum)",
               use(revision_), use(previous_), use(room_), use(id_), use(state_), use(checksum_))),
      add_((sql.prepare << "INSERT INTO places (room, id, revision, cell, changed, expires, "
                           "is_public) VALUES (:room, :id, :revision, :cell, :changed, :expires, "
                           ":is_public)",
            use(room_), use(id_), use(revision_), use(cell_, has_cell_),
            use(changed_, has_changed_), use(expires_, expires_ever_), use(is_public_))),
      change_((sql.prepare << "UPDATE places SET revision = :revision, cell = :cell, changed = "
                              ":changed, expires = :expires, is_public = :is_public WHERE room = "
                              ":room AND id = :id",
               use(revision_), use(cell_, has_cell_), use(changed_, has_changed_),
               use(expires_, expires_ever_), use(is_public_), use(room_), use(id_))),
      find_usage_((sql.prepare << "SELECT anchors, bytes FROM usage WHERE room = :room AND owner = "
                                  ":owner",
                   use(room_), use(id_), into(row_revision_), into(row_key_))),
      put_usage_((sql.prepare << "INSERT INTO usage (room, owner, anchors, bytes) VALUES (:room, "
                                 ":owner, :anchors, :bytes) ON CONFLICT (room, owner) DO UPDATE "
                                 "SET anchors = excluded.anchors, bytes = excluded.bytes",
                  use(room_), use(id_), use(first_), use(last_))) {}

std::uint64_t SqliteStatements::Latest() {
  latest_.execute();
  while (latest_.fetch()) continue;
  return static_cast<std::uint64_t>(row_revision_);
}

void SqliteStatements::Fetch(soci::statement& statement, std::vector<LogRow>& rows) {
  statement.execute();
  while (statement.fetch()) {
    rows.push_back({.revision = static_cast<std::uint64_t>(row_revision_),
                    .previous = static_cast<std::uint64_t>(row_previous_),
                    .room = row_room_,
                    .id = row_id_,
                    .state = row_state_,
                    .checksum = row_checksum_});
  }
}

void SqliteStatements::AddLatest(const AnchorKey& key, std::vector<LogRow>& rows) {
  room_ = key.room.text();
  id_ = key.id.text();
  // What a row without a state leaves unset.
  row_state_.clear();
  row_previous_ = row_checksum_ = 0;
  Fetch(find_, rows);
}

void SqliteStatements::AddState(std::uint64_t revision, std::vector<LogRow>& rows) {
  revision_ = Clamp(revision);
  Fetch(load_, rows);
}

std::vector<Position> SqliteStatements::FindPlaces(const Scan& scan) {
  if (scan.room) room_ = scan.room->text();
  key_ = scan.after.key;
  revision_ = Clamp(scan.after.revision);
  newest_ = Clamp(scan.newest);
  soci::statement& statement = !scan.room                          ? public_by_cell_
                               : scan.order == ScanOrder::kChanged ? by_change_
                                                                   : by_cell_;
  std::vector<Position> positions;
  for (const auto& [first, last] : scan.ranges) {
    if (last < scan.after.key || positions.size() >= scan.limit) continue;
    first_ = first;
    last_ = last;
    limit_ = Clamp(scan.limit - positions.size());
    statement.execute();
    while (statement.fetch()) {
      positions.push_back({row_key_, static_cast<std::uint64_t>(row_revision_)});
    }
  }
  return positions;
}

std::vector<LogRow> SqliteStatements::LoadLog(std::uint64_t after, std::size_t limit) {
  revision_ = Clamp(after);
  limit_ = Clamp(limit);
  std::vector<LogRow> rows;
  Fetch(log_, rows);
  return rows;
}

std::vector<LogRow> SqliteStatements::LoadRoomLog(const RoomId& room, std::uint64_t after,
                                                  std::size_t limit) {
  room_ = room.text();
  revision_ = Clamp(after);
  limit_ = Clamp(limit);
  std::vector<LogRow> rows;
  Fetch(room_log_, rows);
  return rows;
}

void SqliteStatements::Append(const LogRow& row) {
  revision_ = Clamp(row.revision);
  previous_ = Clamp(row.previous);
  room_ = row.room;
  id_ = row.id;
  state_ = row.state;
  checksum_ = row.checksum;
  append_.execute(true);
}

void SqliteStatements::Bind(const std::optional<std::int64_t>& value, long long& number,
                            soci::indicator& presence) {
  presence = value ? soci::i_ok : soci::i_null;
  number = value.value_or(0);
}

void SqliteStatements::Bind(const PlaceRow& place) {
  room_ = place.key.room.text();
  id_ = place.key.id.text();
  revision_ = Clamp(place.revision);
  Bind(place.cell, cell_, has_cell_);
  Bind(place.changed, changed_, has_changed_);
  Bind(place.expires, expires_, expires_ever_);
  is_public_ = place.is_public ? 1 : 0;
}

void SqliteStatements::Add(const PlaceRow& place) {
  Bind(place);
  add_.execute(true);
}

void SqliteStatements::Change(const PlaceRow& place) {
  Bind(place);
  change_.execute(true);
}

std::optional<Usage> SqliteStatements::FindUsage(const OwnerKey& owner) {
  room_ = owner.room;
  id_ = owner.owner;
  std::optional<Usage> usage;
  find_usage_.execute();
  while (find_usage_.fetch()) usage = {row_revision_, row_key_};
  return usage;
}

void SqliteStatements::PutUsage(const OwnerKey& owner, const Usage& usage) {
  room_ = owner.room;
  id_ = owner.owner;
  first_ = usage.anchors;
  last_ = usage.bytes;
  put_usage_.execute(true);
}

}  // namespace waymark::content::internal
