// SPDX-License-Identifier: Apache-2.0
#include "content_store/store_check.h"

#include <algorithm>

#include "content_store/internal/anchor_tables.h"
#include "content_store/internal/open_database.h"

namespace waymark::content {
namespace {

using internal::AnchorKey;
using internal::AnchorState;
using internal::AnchorTables;
using internal::LogRow;
using internal::OwnerKey;
using internal::PlaceRow;
using internal::Usage;

constexpr std::size_t kMaxProblems = 100;
constexpr std::size_t kChunk = 1024;  // rows held at once

/// One reading of everything; its parts run one after the other on one picture of the database.
class Checker {
 public:
  explicit Checker(AnchorTables& tables) : tables_(tables) {}

  StoreCheck Run() && {
    Attempt([&] {
      for (const std::string& finding : tables_.CheckStructure()) Report(finding);
    });
    Attempt([&] { CheckLog(); });
    Attempt([&] { CheckIndex(); });
    Attempt([&] { CheckUsage(); });
    const std::size_t latest = check_.anchors + check_.deleted;
    check_.superseded = states_ > latest ? states_ - latest : 0;
    return std::move(check_);
  }

 private:
  void Report(std::string problem) {
    if (check_.problems.size() < kMaxProblems) check_.problems.push_back(std::move(problem));
  }

  /// Adds what a part failed with to the report: one damaged part does not end the check.
  template <typename Action>
  void Attempt(Action&& action) {
    const Result<void> result = tables_.Guard([&]() -> Result<void> {
      action();
      return {};
    });
    if (!result) Report(result.error().message);
  }

  void CheckLog() {
    check_.revision = tables_.LatestRevision();
    const internal::Compaction compaction = tables_.LoadCompaction();
    check_.compacted_through = compaction.through;
    std::uint64_t compacted_rows = 0, last = 0;
    for (;;) {
      const std::vector<LogRow> rows = tables_.LoadLog(std::nullopt, last, kChunk);
      for (const LogRow& row : rows) {
        const std::uint64_t expected = std::max(last, compaction.through) + 1;
        if (row.revision > expected) {
          Report(fmt::format("expected revision {} in the log, found {}", expected, row.revision));
        }
        if (row.revision <= compaction.through) ++compacted_rows;
        last = row.revision;
        ++states_;
        const auto state = VerifyRow(tables_.name(), row);
        if (!state) Report(state.error().message);
        if (row.previous > compaction.through) ++replacing_;
      }
      if (rows.size() < kChunk || check_.problems.size() >= kMaxProblems) break;
    }
    if (compacted_rows != compaction.rows) {
      Report(fmt::format("expected {} states up to revision {}, found {}", compaction.rows,
                         compaction.through, compacted_rows));
    }
  }

  /// Every row of the index against the state that it points to, and their number against the log.
  void CheckIndex() {
    std::optional<AnchorKey> after;
    std::size_t recent = 0;
    for (;;) {
      const std::vector<PlaceRow> places = tables_.ListPlaces(after, kChunk);
      if (places.empty()) break;
      after = places.back().key;
      std::vector<AnchorKey> keys;
      for (const PlaceRow& place : places) keys.push_back(place.key);
      std::map<AnchorKey, LogRow> rows;
      for (LogRow& row : tables_.FindLatest(keys)) {
        const AnchorKey key{RoomId(row.room), AnchorId(row.id)};
        rows.emplace(key, std::move(row));
      }
      for (const PlaceRow& place : places) {
        recent += place.revision > check_.compacted_through ? 1 : 0;
        CheckPlace(place, rows);
      }
    }
    // Above the compacted part every state is the latest of its anchor or was replaced.
    const std::uint64_t above =
        check_.revision - std::min(check_.revision, check_.compacted_through);
    const std::uint64_t indexed = recent + replacing_;
    if (indexed < above) {
      Report(fmt::format("the index misses {} states of the log", above - indexed));
    } else if (indexed > above) {
      Report(fmt::format("the log misses {} states of the index", indexed - above));
    }
  }

  void CheckPlace(const PlaceRow& place, const std::map<AnchorKey, LogRow>& rows) {
    ++(place.cell ? check_.anchors : check_.deleted);
    const std::string id = place.key.id.text();
    const auto row = rows.find(place.key);
    if (row == rows.end() || row->second.state.empty()) {
      Report(fmt::format("index of anchor {}: points to revision {}, which is not there", id,
                         place.revision));
      return;
    }
    const auto state = VerifyRow(tables_.name(), row->second);
    if (!state) {
      Report(fmt::format("index of anchor {}: {}", id, state.error().message));
      return;
    }
    const PlaceRow expected = ToPlaceRow(*state);
    if (expected.cell != place.cell) {
      Report(fmt::format("index of anchor {}: expected the cell of its place", id));
    }
    if (expected.changed != place.changed || expected.expires != place.expires ||
        expected.is_public != place.is_public) {
      Report(fmt::format("index of anchor {}: expected the times and the visibility of its state",
                         id));
    }
    if (state->is_deleted) return;
    Usage& usage = usage_[{place.key.room.text(), state->record.owner}];
    ++usage.anchors;
    usage.bytes += std::ssize(state->record.payload);
  }

  void CheckUsage() {
    std::map<OwnerKey, Usage> all = tables_.ListUsage();
    for (const auto& [owner, counted] : usage_) all.try_emplace(owner);  // as if it said nothing
    for (const auto& [owner, recorded] : all) {
      const Usage counted = usage_[owner];
      if (recorded.anchors == counted.anchors && recorded.bytes == counted.bytes) continue;
      Report(
          fmt::format("usage of owner {} in room {}: expected {} anchors and {} bytes, found {} "
                      "and {}",
                      owner.owner, owner.room, counted.anchors, counted.bytes, recorded.anchors,
                      recorded.bytes));
    }
  }

  AnchorTables& tables_;
  StoreCheck check_;
  std::size_t states_ = 0;
  std::uint64_t replacing_ = 0;  // states whose predecessor lies above the compacted part
  std::map<OwnerKey, Usage> usage_;
};

}  // namespace

Result<StoreCheck> CheckStore(const std::string& location) {
  WAYMARK_TRY_ASSIGN(const auto database,
                     internal::OpenDatabase(
                         location, {.mode = OpenMode::kExisting, .migration = Migration::kRefuse}));
  WAYMARK_TRY_ASSIGN(const auto tables, database->Connect());
  return tables->Read([&]() -> Result<StoreCheck> { return Checker(*tables).Run(); });
}

Result<StoreCheck> CheckSqliteStore(const std::filesystem::path& file) {
  return CheckStore(file.string());
}

}  // namespace waymark::content
