// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/postgres_schema.h"

#include "content_store/internal/schema_version.h"

namespace waymark::content::internal {
namespace {

constexpr int kFirstVersion = 2;  // version 1 was SQLite's alone

// Texts compare by their bytes, as in SQLite. FORMAT.md explains every column.
constexpr const char* kVersion2[] = {
    "CREATE SCHEMA waymark",
    "CREATE TABLE waymark.facts (name text COLLATE \"C\" PRIMARY KEY, value bigint NOT NULL)",
    "CREATE TABLE waymark.states (revision bigint PRIMARY KEY, previous bigint NOT NULL, room text "
    "COLLATE \"C\" NOT NULL, id text COLLATE \"C\" NOT NULL, state bytea NOT NULL, checksum bigint "
    "NOT NULL)",
    "CREATE INDEX states_by_room ON waymark.states (room, revision)",
    "CREATE TABLE waymark.places (room text COLLATE \"C\" NOT NULL, id text COLLATE \"C\" NOT "
    "NULL, "
    "revision bigint NOT NULL, cell bigint, changed bigint, expires bigint, is_public boolean NOT "
    "NULL, PRIMARY KEY (room, id))",
    "CREATE INDEX places_by_cell ON waymark.places (room, cell, revision) WHERE cell IS NOT NULL",
    "CREATE INDEX places_by_change ON waymark.places (room, changed, revision) WHERE changed IS "
    "NOT NULL",
    "CREATE INDEX places_by_expiry ON waymark.places (expires) WHERE expires IS NOT NULL",
    "CREATE INDEX public_places_by_cell ON waymark.places (cell, revision) WHERE is_public",
    "CREATE TABLE waymark.usage (room text COLLATE \"C\" NOT NULL, owner text COLLATE \"C\" NOT "
    "NULL, anchors bigint NOT NULL, bytes bigint NOT NULL, PRIMARY KEY (room, owner))",
};

/// 0: there is no store.
int ReadVersion(soci::session& sql) {
  int is_there = 0, version = 0;
  sql << "SELECT count(*) FROM pg_catalog.pg_class c JOIN pg_catalog.pg_namespace n ON n.oid = "
         "c.relnamespace WHERE n.nspname = 'waymark' AND c.relname = 'facts'",
      soci::into(is_there);
  if (is_there == 0) return 0;
  sql << "SELECT coalesce(max(value), 0) FROM waymark.facts WHERE name = 'schema_version'",
      soci::into(version);
  return version;
}

void Migrate(soci::session& sql, int version) {
  if (version < kFirstVersion) {
    for (const char* statement : kVersion2) sql << statement;
  }
  sql << "INSERT INTO waymark.facts (name, value) VALUES ('schema_version', :version) ON CONFLICT "
         "(name) DO UPDATE SET value = excluded.value",
      soci::use(kSchemaVersion);
}

/// As every write does: 'WMAN', until the transaction ends.
void LockWriters(soci::session& sql) {
  sql << "SELECT pg_catalog.pg_advisory_xact_lock(1464680782)";
}

}  // namespace

Result<void> PreparePostgresSchema(soci::session& sql, const std::string& name,
                                   const StoreOptions& options) {
  int version = ReadVersion(sql);
  if (version == 0 && options.mode == OpenMode::kExisting) {
    return MakeError(ErrorCode::kNotFound, "{}: there is no anchor store", name);
  }
  if (version > 0 && version < kFirstVersion) {
    return MakeError(ErrorCode::kUnsupported, "{}: expected schema version {} to {}, found {}",
                     name, kFirstVersion, kSchemaVersion, version);
  }
  if (version > 0 && version < kSchemaVersion && options.migration == Migration::kRefuse) {
    return RefuseMigration(name, version);
  }
  if (version < kSchemaVersion) {
    // In one transaction; whoever lost the race finds it done.
    soci::transaction transaction(sql);
    LockWriters(sql);
    version = ReadVersion(sql);
    if (version < kSchemaVersion) Migrate(sql, version);
    transaction.commit();
    version = ReadVersion(sql);
  }
  if (version == kSchemaVersion) return {};
  return MakeError(ErrorCode::kUnsupported, "{}: expected schema version {}, found {}", name,
                   kSchemaVersion, version);
}

}  // namespace waymark::content::internal
