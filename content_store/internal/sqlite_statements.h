// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <soci/soci.h>

#include <cstdint>
#include <string>
#include <vector>

#include "content_store/internal/anchor_tables.h"

namespace waymark::content::internal {

/// The prepared statements that every write and read of SQLite runs, and what they are bound to.
/// Each is read to its end: one left half-way would hold its old picture of the database for all
/// that follow.
class SqliteStatements {
 public:
  explicit SqliteStatements(soci::session& sql);
  SqliteStatements(const SqliteStatements&) = delete;
  SqliteStatements& operator=(const SqliteStatements&) = delete;

  std::uint64_t Latest();
  void AddLatest(const AnchorKey& key, std::vector<LogRow>& rows);
  void AddState(std::uint64_t revision, std::vector<LogRow>& rows);
  std::vector<Position> FindPlaces(const Scan& scan);
  std::vector<LogRow> LoadLog(std::uint64_t after, std::size_t limit);
  std::vector<LogRow> LoadRoomLog(const RoomId& room, std::uint64_t after, std::size_t limit);
  void Append(const LogRow& row);
  void Add(const PlaceRow& place);
  void Change(const PlaceRow& place);
  std::optional<Usage> FindUsage(const OwnerKey& owner);
  void PutUsage(const OwnerKey& owner, const Usage& usage);

 private:
  void Fetch(soci::statement& statement, std::vector<LogRow>& rows);
  void Bind(const PlaceRow& place);
  void Bind(const std::optional<std::int64_t>& value, long long& number, soci::indicator& presence);

  // What the statements below are bound to.
  std::string room_, id_, state_;
  long long revision_ = 0, previous_ = 0, checksum_ = 0, first_ = 0, last_ = 0, newest_ = 0;
  long long key_ = 0, limit_ = 0, cell_ = 0, changed_ = 0, expires_ = 0, is_public_ = 0;
  soci::indicator has_cell_ = soci::i_null, has_changed_ = soci::i_null,
                  expires_ever_ = soci::i_null;
  // What they read into.
  std::string row_room_, row_id_, row_state_;
  long long row_revision_ = 0, row_previous_ = 0, row_key_ = 0, row_checksum_ = 0;
  soci::indicator row_presence_[3] = {};
  soci::statement latest_, find_, load_, by_cell_, by_change_, public_by_cell_, log_, room_log_;
  soci::statement append_, add_, change_, find_usage_, put_usage_;
};

}  // namespace waymark::content::internal
