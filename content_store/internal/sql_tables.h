// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <soci/soci.h>

#include <string>

#include "content_store/internal/anchor_tables.h"

namespace waymark::content::internal {

/// What both databases are asked in the same words: lists, checks and compaction. What is asked
/// often has prepared statements, which are each database's own.
class SqlTables : public AnchorTables {
 public:
  Compaction LoadCompaction() override;
  std::vector<std::uint64_t> ListRoom(const RoomId& room) override;
  std::vector<std::uint64_t> FindReplaced(const std::optional<RoomId>& room, std::uint64_t since,
                                          std::size_t limit) override;
  std::vector<RoomSummary> ListRooms() override;
  std::vector<PlaceRow> FindExpired(std::int64_t now_utc_ms, std::size_t limit) override;
  std::vector<PlaceRow> ListPlaces(const std::optional<AnchorKey>& after,
                                   std::size_t limit) override;
  std::map<OwnerKey, Usage> ListUsage() override;
  std::uint64_t CountLog(std::uint64_t after, std::uint64_t through) override;
  void RemoveSuperseded(std::uint64_t after, std::uint64_t through) override;
  void StoreCompaction(const Compaction& compaction) override;

 protected:
  /// `schema` stands before the name of every table: "" or "waymark.".
  explicit SqlTables(std::string schema) : schema_(std::move(schema)) {}

  virtual soci::session& sql() = 0;

 private:
  std::string Table(const char* name) const { return schema_ + name; }

  const std::string schema_;
};

}  // namespace waymark::content::internal
