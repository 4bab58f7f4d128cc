// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <soci/soci.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "content_store/anchor_store.h"
#include "content_store/internal/record_codec.h"
#include "content_store/internal/sql_session.h"

namespace waymark::content::internal {

/// Where a live anchor is, without its record.
struct Candidate {
  std::int64_t cell;
  std::uint64_t revision;
};

/// The prepared statements of one connection; FORMAT.md describes the tables. Every state that
/// leaves here has passed its checksum and agrees with its keys. Each statement is read to its end:
/// one left half-way would hold its old picture of the database for all that follow.
/// Thread-compatible; all functions throw what SOCI throws, so call them inside a Guard.
class AnchorTables {
 public:
  explicit AnchorTables(SqlSession& session);
  AnchorTables(const AnchorTables&) = delete;
  AnchorTables& operator=(const AnchorTables&) = delete;

  std::uint64_t LatestRevision();
  /// The latest state of an anchor, which may be its deletion. Errors: Corrupt.
  Result<std::optional<AnchorState>> FindState(const RoomId& room, const AnchorId& id);
  /// Errors: Corrupt when the index points to a revision that is damaged or not there.
  Result<AnchorState> LoadState(std::uint64_t revision);
  /// The state of a live anchor of this room. Errors: Corrupt when it is anything else.
  Result<AnchorRecord> LoadLive(const RoomId& room, std::uint64_t revision);
  /// Live anchors of a room, by id. Errors: Corrupt.
  Result<std::vector<AnchorRecord>> LoadRoom(const RoomId& room);
  std::vector<Candidate> FindCandidates(const RoomId& room, std::int64_t first_cell,
                                        std::int64_t last_cell);
  Result<std::vector<AnchorChange>> LoadChanges(std::uint64_t after_revision, std::size_t limit);
  std::vector<RoomSummary> ListRooms();

  /// Adds the state to the log at its revision and makes it the anchor's latest.
  void Append(const AnchorState& state);

 private:
  Result<AnchorState> VerifyRow() const;

  SqlSession& session_;
  // What the statements below are bound to.
  std::string room_, id_, state_;
  long long revision_ = 0, cell_ = 0, checksum_ = 0, first_ = 0, last_ = 0;
  soci::indicator cell_presence_ = soci::i_ok;
  // What they read into.
  std::string row_room_, row_id_, row_state_;
  long long row_revision_ = 0, row_cell_ = 0, row_checksum_ = 0;
  soci::statement pointer_, load_, load_room_, candidates_, changes_, latest_, append_, point_;
};

}  // namespace waymark::content::internal
