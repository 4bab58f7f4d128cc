// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sqlite3.h>

#include <filesystem>
#include <mutex>
#include <vector>

#include "content_store/anchor_record.h"

namespace waymark::bench {

/// What one would write by hand for the same promise: a durable row per anchor, found by place. One
/// table, prepared statements, WAL, synchronous=FULL; no checksum, log, revision or validation.
class RawSqlite {
 public:
  enum class Index { kBTree, kRTree };  ///< on (room, latitude, longitude), or an R*Tree

  RawSqlite(const std::filesystem::path& file, Index index);
  RawSqlite(const RawSqlite&) = delete;
  RawSqlite& operator=(const RawSqlite&) = delete;
  ~RawSqlite();

  /// One durable insert, one transaction. Thread-safe.
  void Create(const content::AnchorRecord& record);
  /// All in one transaction.
  void Load(const std::vector<content::AnchorRecord>& records);
  /// Bytes of the anchors within the radius, nearest first.
  std::vector<std::string> FindNear(const RoomId& room, const GeoPoint& centre, double radius_m);

 private:
  void Run(const char* statement);
  void Insert(const content::AnchorRecord& record);

  std::mutex mutex_;
  sqlite3* database_ = nullptr;  // guarded by mutex_, like the statements
  sqlite3_stmt* insert_ = nullptr;
  sqlite3_stmt* insert_box_ = nullptr;
  sqlite3_stmt* near_ = nullptr;
};

}  // namespace waymark::bench
