// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/anchor_tables.h"

#include <span>
#include <unordered_map>

#include "content_store/internal/cell_index.h"
#include "mapping/base/content_hash.h"

namespace waymark::content::internal {
namespace {

std::int64_t ChecksumOf(const std::string& state) {
  return static_cast<std::int64_t>(
      Checksum(std::span(reinterpret_cast<const std::uint8_t*>(state.data()), state.size())));
}

}  // namespace

Result<AnchorState> VerifyRow(const std::string& store, const LogRow& row) {
  const auto damaged = [&](std::string_view what) {
    return MakeError(ErrorCode::kCorrupt, "{}: revision {}: {}", store, row.revision, what);
  };
  const std::int64_t checksum = ChecksumOf(row.state);
  if (checksum != row.checksum) {
    return damaged(fmt::format("expected checksum {:016x}, found {:016x}",
                               static_cast<std::uint64_t>(row.checksum),
                               static_cast<std::uint64_t>(checksum)));
  }
  auto state = DecodeState(row.state);
  if (!state) return damaged(state.error().message);
  const AnchorRecord& record = state->record;
  if (record.revision != row.revision || record.room.text() != row.room ||
      record.id.text() != row.id) {
    return damaged("its keys and its state disagree");
  }
  if (row.previous >= row.revision) return damaged("its predecessor is not older");
  return state;
}

LogRow ToLogRow(const AnchorState& state, std::uint64_t previous) {
  LogRow row{.revision = state.record.revision,
             .previous = previous,
             .room = state.record.room.text(),
             .id = state.record.id.text(),
             .state = EncodeState(state),
             .checksum = 0};
  row.checksum = ChecksumOf(row.state);
  return row;
}

PlaceRow ToPlaceRow(const AnchorState& state) {
  const AnchorRecord& record = state.record;
  PlaceRow row{.key = {record.room, record.id}, .revision = record.revision};
  if (state.is_deleted) return row;
  row.cell = CellOf({record.place.latitude.radians(), record.place.longitude.radians()});
  row.changed = record.changed_utc_ms;
  row.expires = record.expires_utc_ms;
  row.is_public = record.visibility == AnchorVisibility::kPublic;
  return row;
}

Result<std::vector<AnchorState>> LoadVerified(AnchorTables& tables,
                                              const std::vector<std::uint64_t>& revisions) {
  std::vector<AnchorState> states;
  if (revisions.empty()) return states;
  const std::vector<LogRow> rows = tables.LoadStates(revisions);
  std::unordered_map<std::uint64_t, const LogRow*> by_revision;
  for (const LogRow& row : rows) by_revision.emplace(row.revision, &row);
  states.reserve(revisions.size());
  for (const std::uint64_t revision : revisions) {
    const auto found = by_revision.find(revision);
    if (found == by_revision.end()) {
      return MakeError(ErrorCode::kCorrupt, "{}: revision {}: expected in the log, found nothing",
                       tables.name(), revision);
    }
    WAYMARK_TRY_ASSIGN(auto state, VerifyRow(tables.name(), *found->second));
    states.push_back(std::move(state));
  }
  return states;
}

Result<std::vector<AnchorRecord>> LoadLive(AnchorTables& tables, const std::optional<RoomId>& room,
                                           const std::vector<std::uint64_t>& revisions) {
  WAYMARK_TRY_ASSIGN(auto states, LoadVerified(tables, revisions));
  std::vector<AnchorRecord> records;
  records.reserve(states.size());
  for (AnchorState& state : states) {
    const bool is_wanted =
        !state.is_deleted &&
        (room ? state.record.room == *room : state.record.visibility == AnchorVisibility::kPublic);
    if (!is_wanted) {
      return MakeError(ErrorCode::kCorrupt, "{}: {}: the index points to revision {} of another",
                       tables.name(), room ? "room " + room->text() : "public anchors",
                       state.record.revision);
    }
    records.push_back(std::move(state.record));
  }
  return records;
}

}  // namespace waymark::content::internal
