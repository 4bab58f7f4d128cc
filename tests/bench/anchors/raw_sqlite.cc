// SPDX-License-Identifier: Apache-2.0
#include <sqlite3.h>

#include <mutex>

#include "content_store/internal/record_codec.h"
#include "mapping/base/check.h"
#include "tests/bench/anchors/raw_store.h"

namespace waymark::bench {
namespace {

void Bind(sqlite3_stmt* statement, int at, const std::string& text) {
  CHECK(sqlite3_bind_text(statement, at, text.data(), static_cast<int>(text.size()),
                          SQLITE_TRANSIENT) == SQLITE_OK);
}

class RawSqlite final : public RawStore {
 public:
  explicit RawSqlite(const std::string& file) {
    CHECK(sqlite3_open(file.c_str(), &database_) == SQLITE_OK);
    Run("PRAGMA journal_mode = WAL");
    Run("PRAGMA synchronous = FULL");
    Run("PRAGMA cache_size = -16384");  // as the store's
    Run("CREATE TABLE anchors (n INTEGER PRIMARY KEY, room TEXT, id TEXT, latitude REAL, "
        "longitude REAL, record BLOB)");
    Run("CREATE UNIQUE INDEX by_id ON anchors (room, id)");
    Run("CREATE INDEX by_place ON anchors (room, latitude, longitude)");
    insert_ = Prepare("INSERT INTO anchors VALUES (NULL, ?1, ?2, ?3, ?4, ?5)");
    near_ = Prepare(
        "SELECT latitude, longitude, record FROM anchors WHERE room = ?1 AND latitude BETWEEN ?2 "
        "AND ?3 AND longitude BETWEEN ?4 AND ?5");
  }
  ~RawSqlite() override {
    for (sqlite3_stmt* statement : {insert_, near_}) sqlite3_finalize(statement);
    sqlite3_close(database_);
  }

  void Create(std::span<const content::AnchorRecord> records) override {
    const std::lock_guard lock(mutex_);
    Run("BEGIN IMMEDIATE");
    for (const content::AnchorRecord& record : records) {
      Bind(insert_, 1, record.room.text());
      Bind(insert_, 2, record.id.text());
      sqlite3_bind_double(insert_, 3, record.place.latitude.degrees());
      sqlite3_bind_double(insert_, 4, record.place.longitude.degrees());
      Bind(insert_, 5, content::internal::EncodeState({.record = record}));
      CHECK(sqlite3_step(insert_) == SQLITE_DONE, "{}", sqlite3_errmsg(database_));
      sqlite3_reset(insert_);
    }
    Run("COMMIT");
  }

  std::vector<std::string> FindNear(const RoomId& room, const GeoPoint& centre,
                                    double radius_m) override {
    const std::lock_guard lock(mutex_);
    const DegreeBox box = BoxAround(centre, radius_m);
    Bind(near_, 1, room.text());
    int at = 2;
    for (const double side : {box.south, box.north, box.west, box.east}) {
      sqlite3_bind_double(near_, at++, side);
    }
    NearRows rows(centre, radius_m);
    while (sqlite3_step(near_) == SQLITE_ROW) {
      const auto* bytes = static_cast<const char*>(sqlite3_column_blob(near_, 2));
      const auto size = static_cast<std::size_t>(sqlite3_column_bytes(near_, 2));
      rows.Add(sqlite3_column_double(near_, 0), sqlite3_column_double(near_, 1),
               std::string(bytes, size));
    }
    sqlite3_reset(near_);
    return std::move(rows).Take();
  }

 private:
  void Run(const char* statement) {
    const int result = sqlite3_exec(database_, statement, nullptr, nullptr, nullptr);
    CHECK(result == SQLITE_OK, "{}: {}", statement, sqlite3_errmsg(database_));
  }
  sqlite3_stmt* Prepare(const char* text) {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(database_, text, -1, &statement, nullptr);
    CHECK(statement != nullptr, "{}", sqlite3_errmsg(database_));
    return statement;
  }

  std::mutex mutex_;
  sqlite3* database_ = nullptr;  // guarded by mutex_, like the statements
  sqlite3_stmt* insert_ = nullptr;
  sqlite3_stmt* near_ = nullptr;
};

}  // namespace

std::unique_ptr<RawStore> OpenRawSqlite(const std::string& file) {
  return std::make_unique<RawSqlite>(file);
}

}  // namespace waymark::bench
