// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/anchor_reads.h"

#include <algorithm>

namespace waymark::content::internal {

Result<std::optional<AnchorRecord>> FindAnchor(AnchorTables& tables, const AnchorKey& key) {
  for (const LogRow& row : tables.FindLatest({key})) {
    WAYMARK_TRY_ASSIGN(auto state, VerifyRow(tables.name(), row));
    if (!state.is_deleted) return std::optional(std::move(state.record));
  }
  return std::optional<AnchorRecord>();
}

Result<RoomSnapshot> LoadSnapshot(AnchorTables& tables, const RoomId& room) {
  constexpr std::size_t kChunk = 1024;
  RoomSnapshot snapshot{.revision = tables.LatestRevision(), .anchors = {}};
  const std::vector<std::uint64_t> revisions = tables.ListRoom(room);
  snapshot.anchors.reserve(revisions.size());
  for (std::size_t begin = 0; begin < revisions.size(); begin += kChunk) {
    const std::size_t end = std::min(begin + kChunk, revisions.size());
    WAYMARK_TRY_ASSIGN(auto records, LoadLive(tables, room,
                                              {revisions.begin() + std::ptrdiff_t(begin),
                                               revisions.begin() + std::ptrdiff_t(end)}));
    std::move(records.begin(), records.end(), std::back_inserter(snapshot.anchors));
  }
  return snapshot;
}

Result<std::vector<AnchorChange>> FindChanges(AnchorTables& tables,
                                              const std::optional<RoomId>& room,
                                              std::uint64_t after_revision, std::size_t limit) {
  const std::vector<LogRow> rows = tables.LoadLog(room, after_revision, limit);
  const std::uint64_t compacted_through = tables.LoadCompaction().through;
  std::vector<AnchorChange> changes;
  changes.reserve(rows.size());
  std::uint64_t last = after_revision;
  for (const LogRow& row : rows) {
    // Above the compacted part the log has every revision; what is missing there was lost.
    const std::uint64_t expected = std::max(last, compacted_through) + 1;
    if (!room && row.revision > expected) {
      return MakeError(ErrorCode::kCorrupt, "{}: expected revision {} in the log, found {}",
                       tables.name(), expected, row.revision);
    }
    last = row.revision;
    WAYMARK_TRY_ASSIGN(auto state, VerifyRow(tables.name(), row));
    AnchorChange change{last, state.record.id, state.record.room, std::nullopt};
    if (!state.is_deleted) change.record = std::move(state.record);
    changes.push_back(std::move(change));
  }
  return changes;
}

}  // namespace waymark::content::internal
