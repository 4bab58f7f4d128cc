// SPDX-License-Identifier: Apache-2.0
#include <sqlite3.h>

#include <optional>

#include "content_store/internal/record_codec.h"
#include "mapping/base/check.h"
#include "tests/bench/anchors/raw_store.h"

namespace waymark::bench {
namespace {

/// A prepared statement.
class Statement {
 public:
  Statement(sqlite3* database, const char* text) : database_(database) {
    sqlite3_prepare_v2(database, text, -1, &statement_, nullptr);
    CHECK(statement_ != nullptr, "{}", sqlite3_errmsg(database));
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  template <typename... Values>
  void Run(const Values&... values) {
    int at = 0;
    (Bind(++at, values), ...);
    first_ = 0;
    int result = 0;
    while ((result = sqlite3_step(statement_)) == SQLITE_ROW) {
      first_ = sqlite3_column_int64(statement_, 0);
    }
    CHECK(result == SQLITE_DONE, "{}", sqlite3_errmsg(database_));
    sqlite3_reset(statement_);
  }
  std::int64_t first() const { return first_; }  ///< column of the last row

 private:
  void Bind(int at, const std::string& text) {
    sqlite3_bind_text(statement_, at, text.data(), static_cast<int>(text.size()), SQLITE_STATIC);
  }
  void Bind(int at, double value) { sqlite3_bind_double(statement_, at, value); }
  void Bind(int at, std::int64_t value) { sqlite3_bind_int64(statement_, at, value); }
  void Bind(int at, const std::optional<std::int64_t>& value) {
    value ? sqlite3_bind_int64(statement_, at, *value) : sqlite3_bind_null(statement_, at);
  }

  sqlite3* const database_;
  sqlite3_stmt* statement_ = nullptr;
  std::int64_t first_ = 0;
};

class Database {
 public:
  explicit Database(const std::string& file) {
    CHECK(sqlite3_open(file.c_str(), &database_) == SQLITE_OK);
    for (const char* setting :
         {"PRAGMA journal_mode = WAL", "PRAGMA synchronous = FULL", "PRAGMA cache_size = -16384",
          "PRAGMA wal_autocheckpoint = 16000"}) {
      Run(setting);  // as the store's
    }
  }
  ~Database() { sqlite3_close(database_); }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  sqlite3* get() const { return database_; }
  std::uint64_t Count() {
    Statement count(database_, "SELECT count(*) FROM anchors");
    count.Run();
    return static_cast<std::uint64_t>(count.first());
  }
  void Run(const char* statement) {
    const int result = sqlite3_exec(database_, statement, nullptr, nullptr, nullptr);
    CHECK(result == SQLITE_OK, "{}: {}", statement, sqlite3_errmsg(database_));
  }

 private:
  sqlite3* database_ = nullptr;
};

class RowStore final : public RawStore {
 public:
  explicit RowStore(const std::string& file) : database_(file) {
    database_.Run(
        "CREATE TABLE IF NOT EXISTS anchors (n INTEGER PRIMARY KEY, room TEXT, id TEXT, latitude "
        "REAL, longitude "
        "REAL, record BLOB)");
    database_.Run("CREATE UNIQUE INDEX IF NOT EXISTS by_id ON anchors (room, id)");
    database_.Run("CREATE INDEX IF NOT EXISTS by_place ON anchors (room, latitude, longitude)");
    insert_.emplace(database_.get(), "INSERT INTO anchors VALUES (NULL, ?1, ?2, ?3, ?4, ?5)");
  }

  void Create(std::span<const content::AnchorRecord> records) override {
    database_.Run("BEGIN IMMEDIATE");
    for (const content::AnchorRecord& record : records) {
      insert_->Run(record.room.text(), record.id.text(), record.place.latitude.degrees(),
                   record.place.longitude.degrees(),
                   content::internal::EncodeState({.record = record}));
    }
    database_.Run("COMMIT");
  }
  std::uint64_t Count() override { return database_.Count(); }

 private:
  Database database_;
  std::optional<Statement> insert_;
};

class SameStore final : public RawStore {
 public:
  explicit SameStore(const std::string& file) : database_(file) {
    for (const char* object :
         {"CREATE TABLE IF NOT EXISTS anchors (revision INTEGER PRIMARY KEY, room TEXT, id TEXT, "
          "latitude REAL, "
          "longitude REAL, changed INTEGER, expires INTEGER, record BLOB)",
          "CREATE UNIQUE INDEX IF NOT EXISTS by_id ON anchors (room, id)",
          "CREATE INDEX IF NOT EXISTS by_place ON anchors (room, latitude, longitude)",
          "CREATE INDEX IF NOT EXISTS by_change ON anchors (room, changed)",
          "CREATE INDEX IF NOT EXISTS by_expiry ON anchors (expires) WHERE expires IS NOT NULL",
          "CREATE TABLE IF NOT EXISTS changes (revision INTEGER PRIMARY KEY, room TEXT, id TEXT)",
          "CREATE INDEX IF NOT EXISTS changes_by_room ON changes (room)",
          "CREATE TABLE IF NOT EXISTS owned (room TEXT, owner TEXT, anchors INTEGER, bytes "
          "INTEGER, "
          "PRIMARY KEY (room, owner)) WITHOUT ROWID"}) {
      database_.Run(object);
    }
    latest_.emplace(database_.get(), "SELECT max(revision) FROM changes");
    insert_.emplace(database_.get(),
                    "INSERT INTO anchors VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8) ON CONFLICT DO "
                    "NOTHING RETURNING 1");
    log_.emplace(database_.get(), "INSERT INTO changes VALUES (?1, ?2, ?3)");
    own_.emplace(database_.get(),
                 "INSERT INTO owned VALUES (?1, ?2, 1, ?3) ON CONFLICT DO UPDATE SET anchors = "
                 "anchors + 1, bytes = bytes + excluded.bytes");
  }

  void Create(std::span<const content::AnchorRecord> records) override {
    database_.Run("BEGIN IMMEDIATE");
    latest_->Run();
    std::int64_t revision = latest_->first();
    for (const content::AnchorRecord& record : records) {
      insert_->Run(++revision, record.room.text(), record.id.text(),
                   record.place.latitude.degrees(), record.place.longitude.degrees(),
                   record.changed_utc_ms, record.expires_utc_ms,
                   content::internal::EncodeState({.record = record}));
      CHECK(insert_->first() == 1, "the id is taken");
      log_->Run(revision, record.room.text(), record.id.text());
      own_->Run(record.room.text(), record.owner, std::ssize(record.payload));
    }
    database_.Run("COMMIT");
  }
  std::uint64_t Count() override { return database_.Count(); }

 private:
  Database database_;
  std::optional<Statement> latest_, insert_, log_, own_;
};

}  // namespace

std::unique_ptr<RawStore> OpenRawSqlite(const std::string& file, Facts facts) {
  if (facts == Facts::kRow) return std::make_unique<RowStore>(file);
  return std::make_unique<SameStore>(file);
}

}  // namespace waymark::bench
