// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/sqlite_session.h"

#include <soci/sqlite3/soci-sqlite3.h>

#include <string>

#include "content_store/internal/sqlite_schema.h"

namespace waymark::content::internal {
namespace {

/// SQLite's primary result codes by what a caller can do about them.
ErrorCode CodeOf(int sqlite_result) {
  switch (sqlite_result & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_NOMEM:
    case SQLITE_IOERR:
    case SQLITE_FULL:
    case SQLITE_CANTOPEN:
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
    case SQLITE_PROTOCOL:
    case SQLITE_INTERRUPT:
      return ErrorCode::kUnavailable;
    default:  // CORRUPT, NOTADB, and what only a damaged database makes our fixed statements do
      return ErrorCode::kCorrupt;
  }
}

std::string_view Explanation(int sqlite_result) {
  switch (sqlite_result & 0xff) {
    case SQLITE_BUSY:
      return " (another process is writing)";
    case SQLITE_NOTADB:
      return " (expected an anchor store)";
    default:
      return "";
  }
}

sqlite_api::sqlite3* Native(soci::session& sql) {
  return static_cast<soci::sqlite3_session_backend*>(sql.get_backend())->conn_;
}

}  // namespace

Error DescribeSqlite(const std::string& name, const std::exception& exception) {
  const auto* from_sqlite = dynamic_cast<const soci::sqlite3_soci_error*>(&exception);
  const int code = from_sqlite != nullptr ? from_sqlite->result() : SQLITE_ERROR;
  if (dynamic_cast<const std::bad_alloc*>(&exception) != nullptr) {
    return MakeError(ErrorCode::kUnavailable, "{}: out of memory", name);
  }
  return MakeError(CodeOf(code), "{}: {}{}", name, exception.what(), Explanation(code));
}

SqliteSession::SqliteSession(const std::filesystem::path& file, const std::string& connection)
    : name_(file.string()), sql_(soci::sqlite3, connection) {}

Result<std::unique_ptr<SqliteSession>> SqliteSession::Open(const std::filesystem::path& file,
                                                           const StoreOptions& options) {
  WAYMARK_TRY(options.Validate());
  // Absolute, so that SQLite reads no special meaning into it; the quote would end SOCI's value.
  const std::string path = std::filesystem::absolute(file).lexically_normal().string();
  if (path.find('"') != std::string::npos || path.find('\0') != std::string::npos) {
    return MakeError(ErrorCode::kInvalidArgument, "{}: expected a path without quotation marks",
                     path);
  }
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return MakeError(ErrorCode::kUnavailable, "{}: expected a file, found a folder", path);
  }
  if (options.mode == OpenMode::kExisting && !std::filesystem::exists(path, ignored)) {
    return MakeError(ErrorCode::kNotFound, "{}: there is no anchor store", path);
  }
  std::unique_ptr<SqliteSession> session;
  try {
    session.reset(
        new SqliteSession(file, fmt::format("db=\"{}\" timeout={}", path, options.busy_timeout_s)));
  } catch (const std::exception& exception) {
    return MakeError(ErrorCode::kUnavailable, "{}: cannot open: {}", path, exception.what());
  }
  try {
    WAYMARK_TRY(PrepareSqliteSchema(session->sql(), session->name(), options));
    session->checkpoints_.emplace(Native(session->sql()), options);
  } catch (const std::exception& exception) {
    return DescribeSqlite(session->name(), exception);
  }
  return session;
}

ConnectionState SqliteSession::state() {
  const auto* backend = static_cast<soci::sqlite3_session_backend*>(sql_.get_backend());
  const int code = sqlite_api::sqlite3_extended_errcode(backend->conn_);
  const bool failed_to_sync = code == SQLITE_IOERR_FSYNC || code == SQLITE_IOERR_DIR_FSYNC;
  return failed_to_sync ? ConnectionState::kUntrusted : ConnectionState::kUsable;
}

}  // namespace waymark::content::internal
