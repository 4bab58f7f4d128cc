// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <soci/sqlite3/soci-sqlite3.h>

#include "content_store/anchor_store.h"

namespace waymark::content::internal {

/// Moves the pages of the write-ahead log to the main file when they are many, and begins the log
/// anew. SQLite by itself begins anew only if nobody reads at that moment: under steady readers
/// its log grows without end, is copied after every commit, and all that read search through it.
/// This waits, a short while, for those who read an older picture; who comes later reads the main
/// file. Thread-compatible, as its connection is.
class SqliteCheckpoints {
 public:
  /// Borrows the connection.
  SqliteCheckpoints(sqlite_api::sqlite3* connection, const StoreOptions& options);
  SqliteCheckpoints(const SqliteCheckpoints&) = delete;
  SqliteCheckpoints& operator=(const SqliteCheckpoints&) = delete;

 private:
  static int AfterCommit(void* self, sqlite_api::sqlite3*, const char* database, int pages);
  void Run(const char* database, int pages);

  sqlite_api::sqlite3* const connection_;
  const int busy_timeout_ms_, wanted_pages_;
  int next_pages_;  // of the log, at which to try
};

}  // namespace waymark::content::internal
