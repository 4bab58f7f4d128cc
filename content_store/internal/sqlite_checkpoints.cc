// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/sqlite_checkpoints.h"

#include <string>

namespace waymark::content::internal {

using namespace sqlite_api;  // where SOCI puts it

namespace {

// Longer than queries take. Who reads for longer, as an export does, makes the log wait, not us.
constexpr int kPatience_ms = 50;

}  // namespace

SqliteCheckpoints::SqliteCheckpoints(sqlite3* connection, const StoreOptions& options)
    : connection_(connection),
      busy_timeout_ms_(1000 * options.busy_timeout_s),
      wanted_pages_(options.checkpoint_pages),
      next_pages_(wanted_pages_) {
  // What a log that had to wait took of the disk it gives back.
  const std::string limit =
      "PRAGMA journal_size_limit = " + std::to_string(std::int64_t{8192} * wanted_pages_);
  sqlite3_exec(connection_, limit.c_str(), nullptr, nullptr, nullptr);
  sqlite3_wal_hook(connection_, AfterCommit, this);
}

int SqliteCheckpoints::AfterCommit(void* self, sqlite3*, const char* database, int pages) {
  static_cast<SqliteCheckpoints*>(self)->Run(database, pages);
  return SQLITE_OK;  // the commit is done, whatever came of this
}

void SqliteCheckpoints::Run(const char* database, int pages) {
  if (pages < next_pages_) {
    if (pages < wanted_pages_) next_pages_ = wanted_pages_;  // somebody began it anew
    return;
  }
  sqlite3_busy_timeout(connection_, kPatience_ms);
  const int result =
      sqlite3_wal_checkpoint_v2(connection_, database, SQLITE_CHECKPOINT_RESTART, nullptr, nullptr);
  sqlite3_busy_timeout(connection_, busy_timeout_ms_);
  next_pages_ = result == SQLITE_OK ? wanted_pages_ : pages + wanted_pages_ / 4;
}

}  // namespace waymark::content::internal
