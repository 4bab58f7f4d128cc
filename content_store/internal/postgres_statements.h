// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "content_store/internal/anchor_tables.h"
#include "content_store/internal/postgres_pipeline.h"

namespace waymark::content::internal {

/// The prepared statements that every write and read of PostgreSQL runs. Each takes all its rows at
/// once, as arrays. What has no answer is only sent: Commit hears how it ended.
class PostgresStatements {
 public:
  explicit PostgresStatements(PostgresPipeline& pipeline);

  void BeginRead() { pipeline_.Send("wm_begin_read"); }
  /// The lock that makes a transaction the only writer until it ends comes with it.
  void BeginWrite();
  void CommitRead();  ///< waits for nothing
  void CommitWrite();
  void Rollback();

  std::uint64_t Latest();
  WriteBasis LoadBasis(const std::vector<AnchorKey>& keys, const std::vector<OwnerKey>& owners);
  std::vector<LogRow> FindLatest(const std::vector<AnchorKey>& keys);
  std::map<OwnerKey, Usage> FindUsage(const std::vector<OwnerKey>& owners);
  std::vector<LogRow> LoadStates(const std::vector<std::uint64_t>& revisions);
  std::vector<Position> FindPlaces(const Scan& scan);
  std::vector<LogRow> LoadLog(const std::optional<RoomId>& room, std::uint64_t after,
                              std::size_t limit);

  /// The transaction fails, with a division by zero, unless this is the revision.
  void Require(std::uint64_t latest);
  void Append(const std::vector<LogRow>& rows);
  void Add(const std::vector<PlaceRow>& places) { SendPlaces("wm_add", places); }
  void Change(const std::vector<PlaceRow>& places) { SendPlaces("wm_change", places); }
  void PutUsage(const std::map<OwnerKey, Usage>& usage);
  void Announce(std::uint64_t revision);

 private:
  void SendFindLatest(const std::vector<AnchorKey>& keys);
  void SendPlaces(const char* query, const std::vector<PlaceRow>& places);
  void SendFindUsage(const std::vector<OwnerKey>& owners);
  PostgresRows AwaitLast();

  PostgresPipeline& pipeline_;
};

}  // namespace waymark::content::internal
