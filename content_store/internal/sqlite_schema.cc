// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/sqlite_schema.h"

#include <array>
#include <span>
#include <string_view>

#include "content_store/internal/schema_version.h"
#include "content_store/internal/sqlite_migrations.h"

namespace waymark::content::internal {
namespace {

constexpr int kApplicationId = 0x574d414e;  // "WMAN"

int ReadNumber(soci::session& sql, const std::string& query) {
  int value = 0;
  sql << query, soci::into(value);
  return value;
}

std::string ReadText(soci::session& sql, const std::string& query) {
  std::string value;
  sql << query, soci::into(value);
  return value;
}

bool IsEmpty(soci::session& sql) {
  return ReadNumber(sql, "PRAGMA application_id") == 0 &&
         ReadNumber(sql, "PRAGMA user_version") == 0 &&
         ReadNumber(sql, "SELECT count(*) FROM sqlite_master") == 0;
}

/// The exact text: a trigger or view that someone slipped in would run inside our statements.
bool HasExactly(soci::session& sql, std::span<const SchemaObject> schema) {
  std::size_t found = 0;
  bool matches = true;
  soci::rowset<soci::row> rows =
      (sql.prepare << "SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY name");
  for (const soci::row& row : rows) {
    matches = matches && found < schema.size() && row.get<std::string>(0) == schema[found].name &&
              row.get<std::string>(1) == schema[found].sql;
    ++found;
  }
  return matches && found == schema.size() && ReadText(sql, "PRAGMA encoding") == "UTF-8";
}

/// The version of an anchor store that is what its version says.
Result<int> CheckSchema(soci::session& sql, const std::string& name) {
  const int application = ReadNumber(sql, "PRAGMA application_id");
  if (application != kApplicationId) {
    return MakeError(
        ErrorCode::kCorrupt,
        "{}: expected an anchor store (application id {:#x}), found an SQLite database "
        "of another program ({:#x})",
        name, kApplicationId, application);
  }
  const int version = ReadNumber(sql, "PRAGMA user_version");
  if (version > kSchemaVersion || version < 1) {
    return MakeError(version > kSchemaVersion ? ErrorCode::kUnsupported : ErrorCode::kCorrupt,
                     "{}: expected schema version {}, found {}", name, kSchemaVersion, version);
  }
  if (!HasExactly(sql, SqliteSchema(version))) {
    return MakeError(ErrorCode::kCorrupt,
                     "{}: expected the tables of schema version {}, found others", name, version);
  }
  return version;
}

/// Creates or migrates in one transaction, so that a killed process leaves the old database or the
/// new one; whoever lost the race finds it done.
Result<void> Upgrade(soci::session& sql, const std::string& name) {
  sql << "BEGIN IMMEDIATE";
  try {
    int version = kSchemaVersion;
    if (IsEmpty(sql)) {
      for (const SchemaObject& object : SqliteSchema(kSchemaVersion)) {
        sql << std::string(object.sql);
      }
      sql << "PRAGMA application_id = " << kApplicationId;
      sql << "PRAGMA user_version = " << kSchemaVersion;
    } else {
      version = ReadNumber(sql, "PRAGMA user_version");
    }
    for (; version < kSchemaVersion; ++version) {
      if (const auto migrated = MigrateSqlite(sql, name, version); !migrated) {
        sql << "ROLLBACK";
        return migrated.error();
      }
      sql << "PRAGMA user_version = " << version + 1;
    }
    sql << "COMMIT";
  } catch (...) {
    try {
      sql << "ROLLBACK";
    } catch (...) {  // the first failure is the one to tell
    }
    throw;
  }
  return {};
}

}  // namespace

Result<void> PrepareSqliteSchema(soci::session& sql, const std::string& name,
                                 const StoreOptions& options) {
  sql << "PRAGMA trusted_schema = OFF";
  sql << "PRAGMA cell_size_check = ON";
  sql << "PRAGMA cache_size = -16384";  // KiB, a connection
  const bool is_new = IsEmpty(sql);
  if (is_new && options.mode == OpenMode::kExisting) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected an anchor store, found an empty file",
                     name);
  }
  int version = 0;
  if (!is_new) {  // before anything writes to a foreign file
    WAYMARK_TRY_ASSIGN(version, CheckSchema(sql, name));
    if (version < kSchemaVersion && options.migration == Migration::kRefuse) {
      return RefuseMigration(name, version);
    }
  }
  const std::string journal = ReadText(sql, "PRAGMA journal_mode = WAL");
  if (journal != "wal") {
    return MakeError(ErrorCode::kUnavailable,
                     "{}: expected a write-ahead log, found journal mode {}", name, journal);
  }
  sql << "PRAGMA synchronous = FULL";
  if (version < kSchemaVersion) {
    WAYMARK_TRY(Upgrade(sql, name));
    WAYMARK_TRY_ASSIGN(version, CheckSchema(sql, name));
  }
  return {};
}

}  // namespace waymark::content::internal
