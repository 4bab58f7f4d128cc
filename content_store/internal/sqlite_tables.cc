// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/sqlite_tables.h"

#include <soci/soci.h>

#include <atomic>

#include "content_store/internal/sql_tables.h"
#include "content_store/internal/sqlite_read_ahead.h"
#include "content_store/internal/sqlite_session.h"
#include "content_store/internal/sqlite_statements.h"

namespace waymark::content::internal {
namespace {

using soci::into;
using soci::use;

class SqliteTables final : public SqlTables {
 public:
  explicit SqliteTables(std::unique_ptr<SqliteSession> session)
      : SqlTables(""),
        session_(std::move(session)),
        statements_(session_->sql()),
        read_ahead_(session_->name(),
                    {.states = FindRoot("states"), .places = FindRoot("places_by_cell")}) {}

  const std::string& name() const override { return session_->name(); }
  Error Describe(const std::exception& exception) const override {
    return DescribeSqlite(name(), exception);
  }
  ConnectionState state() override { return session_->state(); }

  void BeginRead() override { sql() << "BEGIN"; }
  void BeginWrite() override { sql() << "BEGIN IMMEDIATE"; }
  void Commit() override { sql() << "COMMIT"; }
  void Rollback() override { sql() << "ROLLBACK"; }

  std::uint64_t LatestRevision() override { return statements_.Latest(); }
  std::vector<LogRow> FindLatest(const std::vector<AnchorKey>& keys) override {
    std::vector<LogRow> rows;
    for (const AnchorKey& key : keys) statements_.AddLatest(key, rows);
    return rows;
  }
  std::vector<LogRow> LoadStates(const std::vector<std::uint64_t>& revisions) override {
    std::vector<LogRow> rows;
    rows.reserve(revisions.size());
    read_ahead_.WantStates(revisions);
    for (const std::uint64_t revision : revisions) statements_.AddState(revision, rows);
    return rows;
  }
  std::vector<Position> FindPlaces(const Scan& scan) override {
    if (scan.room && scan.order == ScanOrder::kCell && scan.after == Position{}) {
      read_ahead_.WantPlaces(scan.room->text(), scan.ranges);
    }
    return statements_.FindPlaces(scan);
  }
  std::vector<LogRow> LoadLog(const std::optional<RoomId>& room, std::uint64_t after,
                              std::size_t limit) override {
    return room ? statements_.LoadRoomLog(*room, after, limit) : statements_.LoadLog(after, limit);
  }
  bool Require(std::uint64_t latest) override { return LatestRevision() == latest; }
  void AppendLog(const std::vector<LogRow>& rows) override {
    for (const LogRow& row : rows) statements_.Append(row);
  }
  void AddPlaces(const std::vector<PlaceRow>& places) override {
    for (const PlaceRow& place : places) statements_.Add(place);
  }
  void ChangePlaces(const std::vector<PlaceRow>& places) override {
    for (const PlaceRow& place : places) statements_.Change(place);
  }
  void Announce(std::uint64_t) override {}
  bool AwaitAnnouncement(std::chrono::milliseconds) override { return false; }

  std::map<OwnerKey, Usage> FindUsage(const std::vector<OwnerKey>& owners) override;
  WriteBasis LoadBasis(const std::vector<AnchorKey>& keys,
                       const std::vector<OwnerKey>& owners) override {
    return {LatestRevision(), FindLatest(keys), FindUsage(owners)};
  }
  void PutUsage(const std::map<OwnerKey, Usage>& usage) override {
    for (const auto& [owner, owned] : usage) statements_.PutUsage(owner, owned);
  }
  void Vacuum() override;
  std::vector<std::string> CheckStructure() override;

 private:
  soci::session& sql() override { return session_->sql(); }

  std::uint32_t FindRoot(const std::string& name) {
    long long page = 0;
    session_->sql() << "SELECT coalesce(max(rootpage), 0) FROM sqlite_master WHERE name = :name",
        use(name), into(page);
    return static_cast<std::uint32_t>(page);
  }

  const std::unique_ptr<SqliteSession> session_;
  SqliteStatements statements_;  // goes before the session
  SqliteReadAhead read_ahead_;
};

std::map<OwnerKey, Usage> SqliteTables::FindUsage(const std::vector<OwnerKey>& owners) {
  std::map<OwnerKey, Usage> usage;
  for (const OwnerKey& owner : owners) {
    if (const auto found = statements_.FindUsage(owner)) usage.emplace(owner, *found);
  }
  return usage;
}

void SqliteTables::Vacuum() {
  sql() << "VACUUM";
  int is_busy = 0;
  sql() << "PRAGMA wal_checkpoint(TRUNCATE)", into(is_busy);
}

std::vector<std::string> SqliteTables::CheckStructure() {
  std::string finding;
  std::vector<std::string> findings;
  soci::statement check = (sql().prepare << "PRAGMA integrity_check", into(finding));
  check.execute();
  while (check.fetch()) {
    if (finding != "ok") findings.push_back(finding);
  }
  return findings;
}

class SqliteDatabase final : public AnchorDatabase {
 public:
  SqliteDatabase(const std::filesystem::path& file, const StoreOptions& options)
      : file_(file), name_(file.string()), options_(options) {}

  const std::string& name() const override { return name_; }
  Result<std::unique_ptr<AnchorTables>> Connect() override {
    StoreOptions options = options_;
    if (was_opened_) options.mode = OpenMode::kExisting;
    WAYMARK_TRY_ASSIGN(auto session, SqliteSession::Open(file_, options));
    was_opened_ = true;
    try {
      return {std::make_unique<SqliteTables>(std::move(session))};
    } catch (const std::exception& exception) {
      return DescribeSqlite(name_, exception);
    }
  }

 private:
  const std::filesystem::path file_;
  const std::string name_;
  const StoreOptions options_;
  std::atomic<bool> was_opened_ = false;
};

}  // namespace

std::unique_ptr<AnchorDatabase> MakeSqliteDatabase(const std::filesystem::path& file,
                                                   const StoreOptions& options) {
  return std::make_unique<SqliteDatabase>(file, options);
}

}  // namespace waymark::content::internal
