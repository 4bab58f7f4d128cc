// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/anchor_tables.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <span>

#include "content_store/internal/cell_index.h"
#include "mapping/base/content_hash.h"

namespace waymark::content::internal {
namespace {

using soci::into;
using soci::use;

long long ChecksumOf(const std::string& state) {
  return static_cast<long long>(
      Checksum(std::span(reinterpret_cast<const std::uint8_t*>(state.data()), state.size())));
}

/// SQL counts to 2^63 - 1; what is beyond finds nothing there either.
template <typename Number>
long long Clamp(Number value) {
  constexpr auto kLargest = std::numeric_limits<long long>::max();
  return value > static_cast<Number>(kLargest) ? kLargest : static_cast<long long>(value);
}

}  // namespace

AnchorTables::AnchorTables(SqlSession& session)
    : session_(session),
      pointer_((session.sql().prepare << "SELECT revision FROM anchors WHERE room = :room "
                                         "AND id = :id",
                use(room_), use(id_), into(row_revision_))),
      load_((session.sql().prepare << "SELECT revision, room, id, state, checksum FROM changes "
                                      "WHERE revision = :revision",
             use(revision_), into(row_revision_), into(row_room_), into(row_id_), into(row_state_),
             into(row_checksum_))),
      load_room_((session.sql().prepare << "SELECT revision FROM anchors WHERE room = :room "
                                           "AND cell IS NOT NULL ORDER BY id",
                  use(room_), into(row_revision_))),
      candidates_((session.sql().prepare << "SELECT cell, revision FROM anchors WHERE room = :room "
                                            "AND cell BETWEEN :first AND :last",
                   use(room_), use(first_), use(last_), into(row_cell_), into(row_revision_))),
      changes_((session.sql().prepare << "SELECT revision, room, id, state, checksum FROM changes "
                                         "WHERE revision > :first ORDER BY revision LIMIT :last",
                use(first_), use(last_), into(row_revision_), into(row_room_), into(row_id_),
                into(row_state_), into(row_checksum_))),
      latest_((session.sql().prepare << "SELECT coalesce(max(revision), 0) FROM changes",
               into(row_revision_))),
      append_((session.sql().prepare << "INSERT INTO changes (revision, room, id, state, checksum) "
                                        "VALUES (:revision, :room, :id, CAST(:state AS BLOB), "
                                        ":checksum)",
               use(revision_), use(room_), use(id_), use(state_), use(checksum_))),
      point_((session.sql().prepare << "INSERT INTO anchors (room, id, revision, cell) "
                                       "VALUES (:room, :id, :revision, :cell) "
                                       "ON CONFLICT (room, id) DO UPDATE "
                                       "SET revision = excluded.revision, cell = excluded.cell",
              use(room_), use(id_), use(revision_), use(cell_, cell_presence_))) {}

Result<AnchorState> AnchorTables::VerifyRow() const {
  const auto damaged = [&](std::string_view what) {
    return MakeError(ErrorCode::kCorrupt, "{}: revision {}: {}", session_.file().string(),
                     row_revision_, what);
  };
  const long long checksum = ChecksumOf(row_state_);
  if (checksum != row_checksum_) {
    return damaged(
        fmt::format("expected checksum {:016x}, found {:016x}", row_checksum_, checksum));
  }
  auto state = DecodeState(row_state_);
  if (!state) return damaged(state.error().message);
  const AnchorRecord& record = state->record;
  if (record.revision != static_cast<std::uint64_t>(row_revision_) ||
      record.room.text() != row_room_ || record.id.text() != row_id_) {
    return damaged("its keys and its state disagree");
  }
  return state;
}

std::uint64_t AnchorTables::LatestRevision() {
  latest_.execute();
  while (latest_.fetch()) continue;
  return static_cast<std::uint64_t>(row_revision_);
}

Result<std::optional<AnchorState>> AnchorTables::FindState(const RoomId& room, const AnchorId& id) {
  room_ = room.text();
  id_ = id.text();
  pointer_.execute();
  bool found = false;
  while (pointer_.fetch()) found = true;
  if (!found) return std::optional<AnchorState>();
  WAYMARK_TRY_ASSIGN(auto state, LoadState(static_cast<std::uint64_t>(row_revision_)));
  if (state.record.room != room || state.record.id != id) {
    return MakeError(ErrorCode::kCorrupt, "{}: room {}, anchor {}: found another anchor's state",
                     session_.file().string(), room.text(), id.text());
  }
  return std::optional(std::move(state));
}

Result<AnchorState> AnchorTables::LoadState(std::uint64_t revision) {
  revision_ = Clamp(revision);
  load_.execute();
  bool found = false;
  while (load_.fetch()) found = true;
  if (!found) {
    return MakeError(ErrorCode::kCorrupt, "{}: revision {}: expected in the log, found nothing",
                     session_.file().string(), revision);
  }
  return VerifyRow();
}

Result<AnchorRecord> AnchorTables::LoadLive(const RoomId& room, std::uint64_t revision) {
  WAYMARK_TRY_ASSIGN(auto state, LoadState(revision));
  if (state.is_deleted || state.record.room != room) {
    return MakeError(ErrorCode::kCorrupt, "{}: room {}: the index points to revision {} of another",
                     session_.file().string(), room.text(), revision);
  }
  return std::move(state.record);
}

Result<std::vector<AnchorRecord>> AnchorTables::LoadRoom(const RoomId& room) {
  room_ = room.text();
  std::vector<std::uint64_t> revisions;
  load_room_.execute();
  while (load_room_.fetch()) revisions.push_back(static_cast<std::uint64_t>(row_revision_));
  std::vector<AnchorRecord> records;
  records.reserve(revisions.size());
  for (const std::uint64_t revision : revisions) {
    WAYMARK_TRY_ASSIGN(auto record, LoadLive(room, revision));
    records.push_back(std::move(record));
  }
  return records;
}

std::vector<Candidate> AnchorTables::FindCandidates(const RoomId& room, std::int64_t first_cell,
                                                    std::int64_t last_cell) {
  room_ = room.text();
  first_ = first_cell;
  last_ = last_cell;
  std::vector<Candidate> candidates;
  candidates_.execute();
  while (candidates_.fetch()) {
    candidates.push_back({row_cell_, static_cast<std::uint64_t>(row_revision_)});
  }
  return candidates;
}

Result<std::vector<AnchorChange>> AnchorTables::LoadChanges(std::uint64_t after_revision,
                                                            std::size_t limit) {
  first_ = Clamp(after_revision);
  last_ = Clamp(limit);
  std::vector<AnchorChange> changes;
  std::optional<Error> error;
  changes_.execute();
  while (changes_.fetch()) {
    if (error) continue;
    auto state = VerifyRow();
    if (!state) {
      error = state.error();
      continue;
    }
    AnchorRecord& record = state->record;
    AnchorChange change{record.revision, record.id, record.room, std::nullopt};
    if (change.revision != after_revision + changes.size() + 1) {
      error =
          MakeError(ErrorCode::kCorrupt, "{}: expected revision {} in the log, found {}",
                    session_.file().string(), after_revision + changes.size() + 1, change.revision);
    }
    if (!state->is_deleted) change.record = std::move(record);
    changes.push_back(std::move(change));
  }
  if (error) return *error;
  return changes;
}

std::vector<RoomSummary> AnchorTables::ListRooms() {
  std::string room;
  long long anchors = 0, revision = 0;
  soci::statement rooms = (session_.sql().prepare << "SELECT room, count(cell), max(revision) "
                                                     "FROM anchors GROUP BY room ORDER BY room",
                           into(room), into(anchors), into(revision));
  std::vector<RoomSummary> summaries;
  rooms.execute();
  while (rooms.fetch()) {
    summaries.push_back(
        {RoomId(room), static_cast<std::size_t>(anchors), static_cast<std::uint64_t>(revision)});
  }
  return summaries;
}

void AnchorTables::Append(const AnchorState& state) {
  const AnchorRecord& record = state.record;
  room_ = record.room.text();
  id_ = record.id.text();
  revision_ = Clamp(record.revision);
  state_ = EncodeState(state);
  checksum_ = ChecksumOf(state_);
  cell_presence_ = state.is_deleted ? soci::i_null : soci::i_ok;
  if (!state.is_deleted) {
    cell_ = CellOf({record.place.latitude.radians(), record.place.longitude.radians()});
  }
  append_.execute(true);
  point_.execute(true);
}

}  // namespace waymark::content::internal
