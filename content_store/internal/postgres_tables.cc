// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/postgres_tables.h"

#include <soci/soci.h>

#include <atomic>

#include "content_store/internal/postgres_schema.h"
#include "content_store/internal/postgres_session.h"
#include "content_store/internal/postgres_statements.h"
#include "content_store/internal/sql_tables.h"

namespace waymark::content::internal {
namespace {

class PostgresTables final : public SqlTables {
 public:
  explicit PostgresTables(std::unique_ptr<PostgresSession> session)
      : SqlTables("waymark."),
        session_(std::move(session)),
        pipeline_(session_->native()),
        statements_(pipeline_) {}

  const std::string& name() const override { return session_->name(); }
  Error Describe(const std::exception& exception) const override {
    return DescribePostgres(name(), exception);
  }
  ConnectionState state() override { return session_->state(); }

  void BeginRead() override {
    is_reading_ = true;
    statements_.BeginRead();
  }
  void BeginWrite() override {
    is_reading_ = false;
    statements_.BeginWrite();
  }
  void Commit() override { is_reading_ ? statements_.CommitRead() : statements_.CommitWrite(); }
  void Rollback() override { statements_.Rollback(); }

  std::uint64_t LatestRevision() override { return statements_.Latest(); }
  std::vector<LogRow> FindLatest(const std::vector<AnchorKey>& keys) override {
    return statements_.FindLatest(keys);
  }
  std::vector<LogRow> LoadStates(const std::vector<std::uint64_t>& revisions) override {
    return statements_.LoadStates(revisions);
  }
  std::vector<Position> FindPlaces(const Scan& scan) override {
    return statements_.FindPlaces(scan);
  }
  std::vector<LogRow> LoadLog(const std::optional<RoomId>& room, std::uint64_t after,
                              std::size_t limit) override {
    return statements_.LoadLog(room, after, limit);
  }
  bool Require(std::uint64_t latest) override {
    statements_.Require(latest);
    return true;
  }
  void AppendLog(const std::vector<LogRow>& rows) override { statements_.Append(rows); }
  void AddPlaces(const std::vector<PlaceRow>& places) override { statements_.Add(places); }
  void ChangePlaces(const std::vector<PlaceRow>& places) override { statements_.Change(places); }
  std::map<OwnerKey, Usage> FindUsage(const std::vector<OwnerKey>& owners) override {
    return statements_.FindUsage(owners);
  }
  WriteBasis LoadBasis(const std::vector<AnchorKey>& keys,
                       const std::vector<OwnerKey>& owners) override {
    return statements_.LoadBasis(keys, owners);
  }
  void PutUsage(const std::map<OwnerKey, Usage>& usage) override { statements_.PutUsage(usage); }
  void Announce(std::uint64_t revision) override { statements_.Announce(revision); }
  bool AwaitAnnouncement(std::chrono::milliseconds timeout) override {
    pipeline_.Finish();
    if (!listens_) session_->Listen();
    listens_ = true;
    session_->AwaitAnnouncement(timeout);
    return true;
  }

  void Vacuum() override;
  /// What a check could ask of PostgreSQL needs an extension; our own checks read every row.
  std::vector<std::string> CheckStructure() override { return {}; }

 private:
  soci::session& sql() override {
    pipeline_.Finish();
    return session_->sql();
  }

  const std::unique_ptr<PostgresSession> session_;
  PostgresPipeline pipeline_;
  PostgresStatements statements_;
  bool is_reading_ = false;  // the transaction under way, or the last one
  bool listens_ = false;
};

void PostgresTables::Vacuum() {
  for (const char* table : {"states", "places", "usage", "facts"}) {
    sql() << fmt::format("VACUUM (ANALYZE) waymark.{}", table);
  }
}

class PostgresDatabase final : public AnchorDatabase {
 public:
  PostgresDatabase(const std::string& uri, const StoreOptions& options)
      : uri_(uri), name_(PublicName(uri)), options_(options) {}

  const std::string& name() const override { return name_; }
  Result<std::unique_ptr<AnchorTables>> Connect() override {
    StoreOptions options = options_;
    if (was_opened_) options.mode = OpenMode::kExisting;
    WAYMARK_TRY_ASSIGN(auto session, PostgresSession::Open(uri_, options));
    was_opened_ = true;
    try {
      return {std::make_unique<PostgresTables>(std::move(session))};
    } catch (const std::exception& exception) {
      return DescribePostgres(name_, exception);
    }
  }

 private:
  const std::string uri_, name_;
  const StoreOptions options_;
  std::atomic<bool> was_opened_ = false;
};

}  // namespace

std::unique_ptr<AnchorDatabase> MakePostgresDatabase(const std::string& uri,
                                                     const StoreOptions& options) {
  return std::make_unique<PostgresDatabase>(uri, options);
}

}  // namespace waymark::content::internal
