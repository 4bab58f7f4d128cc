// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <soci/soci.h>

#include <initializer_list>
#include <string>
#include <vector>

#include "content_store/internal/anchor_tables.h"
#include "content_store/internal/postgres_arrays.h"

namespace waymark::content::internal {

/// The prepared statements that every write and read of PostgreSQL runs. Each takes all its rows in
/// one round trip, as arrays.
class PostgresStatements {
 public:
  explicit PostgresStatements(soci::session& sql);
  PostgresStatements(const PostgresStatements&) = delete;
  PostgresStatements& operator=(const PostgresStatements&) = delete;

  std::uint64_t Latest();
  std::vector<LogRow> FindLatest(const std::vector<AnchorKey>& keys);
  std::vector<LogRow> LoadStates(const std::vector<std::uint64_t>& revisions);
  std::vector<Position> FindPlaces(const Scan& scan);
  std::vector<LogRow> LoadLog(std::uint64_t after, std::size_t limit);
  std::vector<LogRow> LoadRoomLog(const RoomId& room, std::uint64_t after, std::size_t limit);
  void Append(const std::vector<LogRow>& rows);
  void Put(const std::vector<PlaceRow>& places);
  std::map<OwnerKey, Usage> FindUsage(const std::vector<OwnerKey>& owners);
  void PutUsage(const std::map<OwnerKey, Usage>& usage);
  void Announce(std::uint64_t revision);

 private:
  /// Makes these the first of the statements' arrays.
  void Bind(std::initializer_list<const PostgresArray*> arrays);
  std::vector<LogRow> Fetch(soci::statement& statement);

  // What the statements below are bound to.
  std::string arrays_[7];
  std::string room_;
  long long revision_ = 0, newest_ = 0, limit_ = 0;
  // What they read into.
  std::string row_room_, row_id_, row_state_;
  long long row_revision_ = 0, row_previous_ = 0, row_checksum_ = 0, row_key_ = 0;
  soci::statement latest_, find_, load_, by_cell_, by_change_, public_by_cell_, log_, room_log_;
  soci::statement append_, put_, find_usage_, put_usage_, announce_;
};

}  // namespace waymark::content::internal
