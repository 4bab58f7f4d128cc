// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/anchors/raw_sqlite.h"

#include <algorithm>
#include <cmath>

#include "content_store/internal/record_codec.h"
#include "mapping/base/check.h"

namespace waymark::bench {
namespace {

void Bind(sqlite3_stmt* statement, int at, const std::string& text) {
  CHECK(sqlite3_bind_text(statement, at, text.data(), static_cast<int>(text.size()),
                          SQLITE_TRANSIENT) == SQLITE_OK);
}

}  // namespace

RawSqlite::RawSqlite(const std::filesystem::path& file, Index index) {
  CHECK(sqlite3_open(file.c_str(), &database_) == SQLITE_OK);
  Run("PRAGMA journal_mode = WAL");
  Run("PRAGMA synchronous = FULL");
  Run("CREATE TABLE anchors (n INTEGER PRIMARY KEY, room TEXT, id TEXT, latitude REAL, "
      "longitude REAL, record BLOB)");
  Run("CREATE UNIQUE INDEX by_id ON anchors (room, id)");
  const char* near = nullptr;
  if (index == Index::kBTree) {
    Run("CREATE INDEX by_place ON anchors (room, latitude, longitude)");
    near =
        "SELECT latitude, longitude, record FROM anchors WHERE room = ?1 AND latitude BETWEEN ?2 "
        "AND ?3 AND longitude BETWEEN ?4 AND ?5";
  } else {
    Run("CREATE VIRTUAL TABLE boxes USING rtree (n, south, north, west, east)");
    near =
        "SELECT latitude, longitude, record FROM boxes CROSS JOIN anchors USING (n) WHERE room = ?1 AND "
        "north >= ?2 AND south <= ?3 AND east >= ?4 AND west <= ?5";
    sqlite3_prepare_v2(database_, "INSERT INTO boxes VALUES (?1, ?2, ?2, ?3, ?3)", -1, &insert_box_,
                       nullptr);
  }
  sqlite3_prepare_v2(database_, "INSERT INTO anchors VALUES (NULL, ?1, ?2, ?3, ?4, ?5)", -1,
                     &insert_, nullptr);
  sqlite3_prepare_v2(database_, near, -1, &near_, nullptr);
  CHECK(insert_ != nullptr && near_ != nullptr);
}

RawSqlite::~RawSqlite() {
  for (sqlite3_stmt* statement : {insert_, insert_box_, near_}) sqlite3_finalize(statement);
  sqlite3_close(database_);
}

void RawSqlite::Create(const content::AnchorRecord& record) {
  const std::lock_guard lock(mutex_);
  Run("BEGIN IMMEDIATE");
  Insert(record);
  Run("COMMIT");
}

void RawSqlite::Load(const std::vector<content::AnchorRecord>& records) {
  const std::lock_guard lock(mutex_);
  Run("BEGIN IMMEDIATE");
  for (const auto& record : records) Insert(record);
  Run("COMMIT");
}

std::vector<std::string> RawSqlite::FindNear(const RoomId& room, const GeoPoint& centre,
                                             double radius_m) {
  const std::lock_guard lock(mutex_);
  const double dlat = radius_m / 110'000, lat = centre.latitude.degrees();
  const double dlon = dlat / std::cos(centre.latitude.radians());
  const double lon = centre.longitude.degrees();
  Bind(near_, 1, room.text());
  const double box[] = {lat - dlat, lat + dlat, lon - dlon, lon + dlon};
  for (int i = 0; i < 4; ++i) sqlite3_bind_double(near_, 2 + i, box[i]);
  std::vector<std::pair<double, std::string>> found;
  while (sqlite3_step(near_) == SQLITE_ROW) {
    const GeoPoint place{.latitude = Angle::Degrees(sqlite3_column_double(near_, 0)),
                         .longitude = Angle::Degrees(sqlite3_column_double(near_, 1)),
                         .ellipsoid_height_m = 0};
    const double distance_m = GeodesicDistance(centre, place);
    if (distance_m > radius_m) continue;
    const auto* bytes = static_cast<const char*>(sqlite3_column_blob(near_, 2));
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(near_, 2));
    found.emplace_back(distance_m, std::string(bytes, size));
  }
  sqlite3_reset(near_);
  std::sort(found.begin(), found.end());
  std::vector<std::string> records;
  for (auto& [distance_m, record] : found) records.push_back(std::move(record));
  return records;
}

void RawSqlite::Run(const char* statement) {
  const int result = sqlite3_exec(database_, statement, nullptr, nullptr, nullptr);
  CHECK(result == SQLITE_OK, "{}: {}", statement, sqlite3_errmsg(database_));
}

void RawSqlite::Insert(const content::AnchorRecord& record) {
  Bind(insert_, 1, record.room.text());
  Bind(insert_, 2, record.id.text());
  sqlite3_bind_double(insert_, 3, record.place.latitude.degrees());
  sqlite3_bind_double(insert_, 4, record.place.longitude.degrees());
  Bind(insert_, 5, content::internal::EncodeState({.record = record}));
  CHECK(sqlite3_step(insert_) == SQLITE_DONE, "{}", sqlite3_errmsg(database_));
  sqlite3_reset(insert_);
  if (insert_box_ == nullptr) return;
  sqlite3_bind_int64(insert_box_, 1, sqlite3_last_insert_rowid(database_));
  sqlite3_bind_double(insert_box_, 2, record.place.latitude.degrees());
  sqlite3_bind_double(insert_box_, 3, record.place.longitude.degrees());
  CHECK(sqlite3_step(insert_box_) == SQLITE_DONE, "{}", sqlite3_errmsg(database_));
  sqlite3_reset(insert_box_);
}

}  // namespace waymark::bench
