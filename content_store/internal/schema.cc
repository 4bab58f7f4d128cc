// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/schema.h"

#include <array>
#include <string>
#include <string_view>

namespace waymark::content::internal {
namespace {

constexpr int kApplicationId = 0x574d414e;  // "WMAN"
constexpr int kSchemaVersion = 1;

struct SchemaObject {
  std::string_view name;
  std::string_view sql;  // as sqlite_master keeps it, byte for byte
};

/// FORMAT.md explains every column. In the order of their names.
constexpr std::array<SchemaObject, 3> kSchema{{
    {"anchors",
     "CREATE TABLE anchors (room TEXT NOT NULL, id TEXT NOT NULL, revision INTEGER NOT NULL, "
     "cell INTEGER, PRIMARY KEY (room, id)) WITHOUT ROWID"},
    {"anchors_by_cell",
     "CREATE INDEX anchors_by_cell ON anchors (room, cell, revision) WHERE cell IS NOT NULL"},
    {"changes",
     "CREATE TABLE changes (revision INTEGER PRIMARY KEY, room TEXT NOT NULL, id TEXT NOT NULL, "
     "state BLOB NOT NULL, checksum INTEGER NOT NULL)"},
}};

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

/// In one transaction, so that a killed process leaves an empty database or a whole one; whoever
/// lost the race to create finds it not empty any more.
void CreateSchema(soci::session& sql) {
  sql << "BEGIN IMMEDIATE";
  try {
    if (IsEmpty(sql)) {
      for (const SchemaObject& object : kSchema) sql << std::string(object.sql);
      sql << "PRAGMA application_id = " << kApplicationId;
      sql << "PRAGMA user_version = " << kSchemaVersion;
    }
    sql << "COMMIT";
  } catch (...) {
    try {
      sql << "ROLLBACK";
    } catch (...) {  // the first failure is the one to tell
    }
    throw;
  }
}

Result<void> CheckSchema(soci::session& sql, const std::filesystem::path& file) {
  const int application = ReadNumber(sql, "PRAGMA application_id");
  if (application != kApplicationId) {
    return MakeError(
        ErrorCode::kCorrupt,
        "{}: expected an anchor store (application id {:#x}), found an SQLite database "
        "of another program ({:#x})",
        file.string(), kApplicationId, application);
  }
  const int version = ReadNumber(sql, "PRAGMA user_version");
  if (version != kSchemaVersion) {
    return MakeError(version > kSchemaVersion ? ErrorCode::kUnsupported : ErrorCode::kCorrupt,
                     "{}: expected schema version {}, found {}", file.string(), kSchemaVersion,
                     version);
  }
  // The exact text: a trigger or view that someone slipped in would run inside our statements.
  std::size_t found = 0;
  soci::rowset<soci::row> rows =
      (sql.prepare << "SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY name");
  bool matches = true;
  for (const soci::row& row : rows) {
    matches = matches && found < kSchema.size() && row.get<std::string>(0) == kSchema[found].name &&
              row.get<std::string>(1) == kSchema[found].sql;
    ++found;
  }
  if (!matches || found != kSchema.size() || ReadText(sql, "PRAGMA encoding") != "UTF-8") {
    return MakeError(ErrorCode::kCorrupt,
                     "{}: expected the tables of schema version {}, found others", file.string(),
                     kSchemaVersion);
  }
  return {};
}

}  // namespace

Result<void> PrepareSchema(soci::session& sql, const std::filesystem::path& file, OpenMode mode) {
  sql << "PRAGMA trusted_schema = OFF";
  sql << "PRAGMA cell_size_check = ON";
  const bool is_new = IsEmpty(sql);
  if (is_new && mode == OpenMode::kExisting) {
    return MakeError(ErrorCode::kCorrupt, "{}: expected an anchor store, found an empty file",
                     file.string());
  }
  if (!is_new) WAYMARK_TRY(CheckSchema(sql, file));  // before anything writes to a foreign file
  const std::string journal = ReadText(sql, "PRAGMA journal_mode = WAL");
  if (journal != "wal") {
    return MakeError(ErrorCode::kUnavailable,
                     "{}: expected a write-ahead log, found journal mode {}", file.string(),
                     journal);
  }
  sql << "PRAGMA synchronous = FULL";
  if (is_new) {
    CreateSchema(sql);
    WAYMARK_TRY(CheckSchema(sql, file));
  }
  return {};
}

}  // namespace waymark::content::internal
