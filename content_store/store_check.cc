// SPDX-License-Identifier: Apache-2.0
#include "content_store/store_check.h"

#include "content_store/internal/anchor_tables.h"
#include "content_store/internal/cell_index.h"
#include "content_store/internal/sql_session.h"

namespace waymark::content {
namespace {

constexpr std::size_t kMaxProblems = 100;

void Report(StoreCheck& check, std::string problem) {
  if (check.problems.size() < kMaxProblems) check.problems.push_back(std::move(problem));
}

/// Adds what an action failed with to the report: one damaged part does not end the check.
template <typename Action>
void Attempt(internal::SqlSession& session, StoreCheck& check, Action&& action) {
  const Result<void> result = session.Guard([&]() -> Result<void> {
    action();
    return {};
  });
  if (!result) Report(check, result.error().message);
}

void CheckPages(internal::SqlSession& session, StoreCheck& check) {
  std::string finding;
  soci::statement findings =
      (session.sql().prepare << "PRAGMA integrity_check", soci::into(finding));
  findings.execute();
  while (findings.fetch()) {
    if (finding != "ok") Report(check, finding);
  }
}

void CheckLog(internal::AnchorTables& tables, StoreCheck& check) {
  check.revision = tables.LatestRevision();
  for (std::uint64_t revision = 1; revision <= check.revision; ++revision) {
    if (check.problems.size() >= kMaxProblems) return;
    if (const auto state = tables.LoadState(revision); !state) {
      Report(check, state.error().message);
    }
  }
}

/// Every row of the index against the state that it points to.
void CheckIndex(internal::SqlSession& session, internal::AnchorTables& tables, StoreCheck& check) {
  std::string room, id;
  long long revision = 0, cell = 0;
  soci::indicator cell_presence = soci::i_ok;
  soci::statement rows =
      (session.sql().prepare << "SELECT room, id, revision, cell FROM anchors", soci::into(room),
       soci::into(id), soci::into(revision), soci::into(cell, cell_presence));
  rows.execute();
  while (rows.fetch()) {
    const auto state = tables.LoadState(static_cast<std::uint64_t>(revision));
    if (!state) {
      Report(check, state.error().message);
      continue;
    }
    const AnchorRecord& record = state->record;
    const bool is_live = cell_presence == soci::i_ok;
    ++(is_live ? check.anchors : check.deleted);
    if (record.room.text() != room || record.id.text() != id || state->is_deleted == is_live) {
      Report(check,
             fmt::format("index of anchor {}: points to revision {} of another", id, revision));
    } else if (is_live && cell != internal::CellOf({record.place.latitude.radians(),
                                                    record.place.longitude.radians()})) {
      Report(check, fmt::format("index of anchor {}: expected the cell of its place", id));
    }
  }
}

long long Count(internal::SqlSession& session, const std::string& query) {
  long long count = 0;
  session.sql() << query, soci::into(count);
  return count;
}

/// Every state of the log is the latest of its anchor, or older than the latest.
void CheckCoverage(internal::SqlSession& session, StoreCheck& check) {
  const long long lost = Count(session,
                               "SELECT count(*) FROM changes c WHERE NOT EXISTS (SELECT 1 FROM "
                               "anchors a WHERE a.room = c.room AND a.id = c.id AND a.revision >= "
                               "c.revision)");
  if (lost > 0) Report(check, fmt::format("the index misses {} states of the log", lost));
  const auto states = static_cast<std::size_t>(Count(session, "SELECT count(*) FROM changes"));
  const std::size_t latest = check.anchors + check.deleted;
  check.superseded = states > latest ? states - latest : 0;
}

}  // namespace

Result<StoreCheck> CheckSqliteStore(const std::filesystem::path& file) {
  WAYMARK_TRY_ASSIGN(const auto session,
                     internal::SqlSession::Open(file, {.mode = OpenMode::kExisting}));
  return session->Read([&]() -> Result<StoreCheck> {
    StoreCheck check;
    internal::AnchorTables tables(*session);
    Attempt(*session, check, [&] { CheckPages(*session, check); });
    Attempt(*session, check, [&] { CheckLog(tables, check); });
    Attempt(*session, check, [&] { CheckIndex(*session, tables, check); });
    Attempt(*session, check, [&] { CheckCoverage(*session, check); });
    return check;
  });
}

}  // namespace waymark::content
