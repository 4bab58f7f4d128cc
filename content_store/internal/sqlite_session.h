// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <soci/soci.h>

#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "content_store/anchor_store.h"
#include "content_store/internal/anchor_tables.h"
#include "content_store/internal/sqlite_checkpoints.h"
#include "mapping/base/result.h"

namespace waymark::content::internal {

/// What an exception of SOCI's SQLite means for the store of this name.
Error DescribeSqlite(const std::string& name, const std::exception& exception);

/// One SQLite connection, and what its exceptions mean. Thread-compatible.
class SqliteSession {
 public:
  /// Opens the file, creating it if the mode says so, and brings its schema to the present version
  /// if the options allow. Errors: NotFound, Unavailable, Corrupt, Unsupported.
  static Result<std::unique_ptr<SqliteSession>> Open(const std::filesystem::path& file,
                                                     const StoreOptions& options);

  soci::session& sql() { return sql_; }
  const std::string& name() const { return name_; }
  ConnectionState state();

 private:
  SqliteSession(const std::filesystem::path& file, const std::string& connection);

  const std::string name_;
  soci::session sql_;
  std::optional<SqliteCheckpoints> checkpoints_;
};

}  // namespace waymark::content::internal
