// SPDX-License-Identifier: Apache-2.0
#include "content_store/store_admin.h"

#include <algorithm>

#include "content_store/internal/open_database.h"

namespace waymark::content {
namespace {

using internal::AnchorTables;

/// One step of a compaction, in its own transaction.
Result<void> CompactStep(AnchorTables& tables, std::uint64_t through, std::uint64_t& done) {
  constexpr std::uint64_t kStep = 20'000;  // revisions; writers wait for one step at most
  return tables.Write([&]() -> Result<void> {
    const internal::Compaction before = tables.LoadCompaction();
    const std::uint64_t next = std::min(through, done + kStep);
    // What was the latest state at an earlier compaction may be superseded by now.
    const std::uint64_t counted = tables.CountLog(done, std::min(next, before.through));
    tables.RemoveSuperseded(done, next);
    tables.StoreCompaction(
        {std::max(before.through, next), before.rows - counted + tables.CountLog(done, next)});
    done = next;
    return {};
  });
}

}  // namespace

Result<CompactionReport> CompactStore(const std::string& location, std::uint64_t keep_revisions) {
  WAYMARK_TRY_ASSIGN(const auto database,
                     internal::OpenDatabase(location, {.mode = OpenMode::kExisting}));
  WAYMARK_TRY_ASSIGN(const auto tables, database->Connect());
  CompactionReport report;
  std::uint64_t through = 0, done = 0;
  WAYMARK_TRY(tables->Read([&]() -> Result<void> {
    const std::uint64_t latest = tables->LatestRevision();
    report.states_before = tables->CountLog(0, latest);
    through = latest - std::min(latest, keep_revisions);
    return {};
  }));
  while (done < through) WAYMARK_TRY(CompactStep(*tables, through, done));
  WAYMARK_TRY(tables->Guard([&]() -> Result<void> {
    tables->Vacuum();
    return {};
  }));
  WAYMARK_TRY(tables->Read([&]() -> Result<void> {
    report.states_after = tables->CountLog(0, tables->LatestRevision());
    report.compacted_through = tables->LoadCompaction().through;
    return {};
  }));
  return report;
}

Result<bool> MigrateStore(const std::string& location) {
  const auto connect = [&](Migration migration) -> Result<void> {
    WAYMARK_TRY_ASSIGN(
        const auto database,
        internal::OpenDatabase(location, {.mode = OpenMode::kExisting, .migration = migration}));
    WAYMARK_TRY_ASSIGN(const auto tables, database->Connect());
    return {};
  };
  if (connect(Migration::kRefuse)) return false;
  WAYMARK_TRY(connect(Migration::kAutomatic));
  return true;
}

}  // namespace waymark::content
