// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/sqlite_migrations.h"

#include <array>
#include <map>

#include "content_store/internal/anchor_tables.h"
#include "mapping/base/check.h"

namespace waymark::content::internal {
namespace {

constexpr std::array<SchemaObject, 3> kVersion1{{
    {"anchors",
     "CREATE TABLE anchors (room TEXT NOT NULL, id TEXT NOT NULL, revision INTEGER NOT NULL, "
     "cell INTEGER, PRIMARY KEY (room, id)) WITHOUT ROWID"},
    {"anchors_by_cell",
     "CREATE INDEX anchors_by_cell ON anchors (room, cell, revision) WHERE cell IS NOT NULL"},
    {"changes",
     "CREATE TABLE changes (revision INTEGER PRIMARY KEY, room TEXT NOT NULL, id TEXT NOT NULL, "
     "state BLOB NOT NULL, checksum INTEGER NOT NULL)"},
}};

// The tables have other names than in version 1, so that both can be there while it is migrated and
// SQLite keeps the text of their creation.
constexpr std::array<SchemaObject, 9> kVersion2{{
    {"facts",
     "CREATE TABLE facts (name TEXT NOT NULL PRIMARY KEY, value INTEGER NOT NULL) WITHOUT ROWID"},
    {"places",
     "CREATE TABLE places (room TEXT NOT NULL, id TEXT NOT NULL, revision INTEGER NOT NULL, cell "
     "INTEGER, changed INTEGER, expires INTEGER, is_public INTEGER NOT NULL, PRIMARY KEY (room, "
     "id)) WITHOUT ROWID"},
    {"places_by_cell",
     "CREATE INDEX places_by_cell ON places (room, cell, revision) WHERE cell IS NOT NULL"},
    {"places_by_change",
     "CREATE INDEX places_by_change ON places (room, changed, revision) WHERE changed IS NOT NULL"},
    {"places_by_expiry",
     "CREATE INDEX places_by_expiry ON places (expires) WHERE expires IS NOT NULL"},
    {"public_places_by_cell",
     "CREATE INDEX public_places_by_cell ON places (cell, revision) WHERE is_public = 1"},
    {"states",
     "CREATE TABLE states (revision INTEGER PRIMARY KEY, previous INTEGER NOT NULL, room TEXT NOT "
     "NULL, id TEXT NOT NULL, state BLOB NOT NULL, checksum INTEGER NOT NULL)"},
    {"states_by_room", "CREATE INDEX states_by_room ON states (room)"},
    {"usage",
     "CREATE TABLE usage (room TEXT NOT NULL, owner TEXT NOT NULL, anchors INTEGER NOT NULL, bytes "
     "INTEGER NOT NULL, PRIMARY KEY (room, owner)) WITHOUT ROWID"},
}};

/// Fills what version 1 knew only inside the states: time of change and who owns how much.
Result<void> ReadStates(soci::session& sql, const std::string& name) {
  std::map<OwnerKey, Usage> usage;
  long long revision = 0, changed = 0, checksum = 0;
  LogRow row;
  soci::statement set = (sql.prepare << "UPDATE places SET changed = :changed WHERE room = :room "
                                        "AND id = :id",
                         soci::use(changed), soci::use(row.room), soci::use(row.id));
  soci::statement states =
      (sql.prepare << "SELECT s.revision, s.room, s.id, s.state, s.checksum FROM places p JOIN "
                      "states s ON s.revision = p.revision WHERE p.cell IS NOT NULL",
       soci::into(revision), soci::into(row.room), soci::into(row.id), soci::into(row.state),
       soci::into(checksum));
  std::optional<Error> error;
  states.execute();
  while (states.fetch()) {
    if (error) continue;
    row.revision = static_cast<std::uint64_t>(revision);
    row.checksum = checksum;
    const auto state = VerifyRow(name, row);
    if (!state) {
      error = state.error();
      continue;
    }
    changed = state->record.changed_utc_ms;
    set.execute(true);
    Usage& owned = usage[{row.room, state->record.owner}];
    ++owned.anchors;
    owned.bytes += std::ssize(state->record.payload);
  }
  if (error) return *error;
  for (const auto& [owner, owned] : usage) {
    const long long anchors = owned.anchors, bytes = owned.bytes;
    sql << "INSERT INTO usage (room, owner, anchors, bytes) VALUES (:room, :owner, :anchors, "
           ":bytes)",
        soci::use(owner.room), soci::use(owner.owner), soci::use(anchors), soci::use(bytes);
  }
  return {};
}

Result<void> MigrateFrom1(soci::session& sql, const std::string& name) {
  for (const SchemaObject& object : kVersion2) sql << std::string(object.sql);
  sql << "INSERT INTO states SELECT revision, lag(revision, 1, 0) OVER (PARTITION BY room, id "
         "ORDER "
         "BY revision), room, id, state, checksum FROM changes";
  sql << "INSERT INTO places SELECT room, id, revision, cell, NULL, NULL, 0 FROM anchors";
  WAYMARK_TRY(ReadStates(sql, name));
  sql << "DROP TABLE anchors";
  sql << "DROP TABLE changes";
  return {};
}

}  // namespace

std::span<const SchemaObject> SqliteSchema(int version) {
  CHECK(version == 1 || version == 2, "schema version {}", version);
  if (version == 1) return kVersion1;
  return kVersion2;
}

Result<void> MigrateSqlite(soci::session& sql, const std::string& name, int version) {
  CHECK(version == 1, "schema version {}", version);
  return MigrateFrom1(sql, name);
}

}  // namespace waymark::content::internal
