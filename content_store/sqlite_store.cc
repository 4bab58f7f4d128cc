// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <mutex>

#include "content_store/anchor_rules.h"
#include "content_store/anchor_store.h"
#include "content_store/internal/anchor_tables.h"
#include "content_store/internal/commit_queue.h"
#include "content_store/internal/nearest.h"
#include "content_store/internal/sql_session.h"

namespace waymark::content {
namespace {

using internal::AnchorState;
using internal::AnchorTables;
using internal::CommitQueue;
using internal::SqlSession;

/// A connection with its statements, which go first.
struct Connection {
  std::unique_ptr<SqlSession> session;
  std::unique_ptr<AnchorTables> tables;

  static Result<Connection> Open(const std::filesystem::path& file,
                                 const SqliteStoreOptions& options) {
    WAYMARK_TRY_ASSIGN(auto session, SqlSession::Open(file, options));
    return session->Guard([&]() -> Result<Connection> {
      auto tables = std::make_unique<AnchorTables>(*session);
      return Connection{std::move(session), std::move(tables)};
    });
  }
};

class SqliteStore final : public AnchorStore {
 public:
  SqliteStore(std::filesystem::path file, const SqliteStoreOptions& options, Connection writer)
      : file_(std::move(file)), options_(options), writer_(std::move(writer)) {}

  Result<WriteOutcome> Create(const AnchorRecord& record) override {
    WAYMARK_TRY(Validate(record));
    return queue_.Run([&] { return DoCreate(record); });
  }
  Result<WriteOutcome> Update(const AnchorRecord& record,
                              std::uint64_t expected_revision) override {
    WAYMARK_TRY(Validate(record));
    return queue_.Run([&] { return DoUpdate(record, expected_revision); });
  }
  Result<WriteOutcome> Delete(const RoomId& room, const AnchorId& id,
                              std::uint64_t expected_revision) override {
    return queue_.Run([&] { return DoDelete(room, id, expected_revision); });
  }

  Result<std::optional<AnchorRecord>> Find(const RoomId& room, const AnchorId& id) override {
    return Read([&](AnchorTables& tables) -> Result<std::optional<AnchorRecord>> {
      WAYMARK_TRY_ASSIGN(auto state, tables.FindState(room, id));
      if (!state || state->is_deleted) return std::optional<AnchorRecord>();
      return std::optional(std::move(state->record));
    });
  }
  Result<RoomSnapshot> LoadRoom(const RoomId& room) override {
    return Read([&](AnchorTables& tables) -> Result<RoomSnapshot> {
      RoomSnapshot snapshot;
      snapshot.revision = tables.LatestRevision();
      WAYMARK_TRY_ASSIGN(snapshot.anchors, tables.LoadRoom(room));
      return snapshot;
    });
  }
  Result<std::vector<RoomSummary>> ListRooms() override {
    return Read([](AnchorTables& tables) -> Result<std::vector<RoomSummary>> {
      return tables.ListRooms();
    });
  }
  Result<std::vector<AnchorRecord>> FindNear(const RoomId& room, const GeoPoint& centre,
                                             double radius_m, std::size_t limit) override {
    WAYMARK_TRY(centre.Validate());
    if (!std::isfinite(radius_m) || radius_m < 0) {
      return MakeError(ErrorCode::kInvalidArgument, "radius: expected at least 0 m, found {}",
                       radius_m);
    }
    if (limit == 0) return std::vector<AnchorRecord>();
    return Read([&](AnchorTables& tables) {
      return internal::FindNearest(tables, room, centre, radius_m, limit);
    });
  }
  Result<std::vector<AnchorChange>> LoadChanges(std::uint64_t after_revision,
                                                std::size_t limit) override {
    return Read([&](AnchorTables& tables) { return tables.LoadChanges(after_revision, limit); });
  }

 private:
  // On the committing thread, inside its transaction.
  Result<WriteOutcome> DoCreate(const AnchorRecord& record);
  Result<WriteOutcome> DoUpdate(const AnchorRecord& record, std::uint64_t expected_revision);
  Result<WriteOutcome> DoDelete(const RoomId& room, const AnchorId& id,
                                std::uint64_t expected_revision);
  WriteOutcome Append(AnchorState state);
  std::vector<Result<WriteOutcome>> Commit(const std::vector<const CommitQueue::Write*>& writes);

  /// Runs `action` on an idle reading connection, or on a new one.
  template <typename Action>
  std::invoke_result_t<Action, AnchorTables&> Read(Action&& action) {
    WAYMARK_TRY_ASSIGN(auto reader, BorrowReader());
    auto result = reader.session->Read([&] { return action(*reader.tables); });
    if (result) ReturnReader(std::move(reader));  // a connection that failed is not trusted again
    return result;
  }
  Result<Connection> BorrowReader();
  void ReturnReader(Connection reader);

  const std::filesystem::path file_;
  const SqliteStoreOptions options_;
  Connection writer_;            // used by the committing thread only
  bool failed_to_sync_ = false;  // the same
  std::mutex readers_mutex_;
  std::vector<Connection> idle_readers_;  // guarded by readers_mutex_
  CommitQueue queue_{[this](const auto& writes) { return Commit(writes); }};
};

WriteOutcome SqliteStore::Append(AnchorState state) {
  state.record.revision = writer_.tables->LatestRevision() + 1;
  writer_.tables->Append(state);
  return std::move(state.record);
}

WriteConflict ConflictWith(std::optional<AnchorState> state) {
  if (!state || state->is_deleted) return {};
  return {std::move(state->record)};
}

Result<WriteOutcome> SqliteStore::DoCreate(const AnchorRecord& record) {
  WAYMARK_TRY_ASSIGN(auto present, writer_.tables->FindState(record.room, record.id));
  std::string creation = ContentFingerprint(record);
  if (!present) return Append({record, std::move(creation)});
  if (!present->is_deleted && present->creation == creation) return {std::move(present->record)};
  return {ConflictWith(std::move(present))};
}

Result<WriteOutcome> SqliteStore::DoUpdate(const AnchorRecord& record,
                                           std::uint64_t expected_revision) {
  WAYMARK_TRY_ASSIGN(auto present, writer_.tables->FindState(record.room, record.id));
  if (!present || present->is_deleted || present->record.revision != expected_revision) {
    return {ConflictWith(std::move(present))};
  }
  AnchorState next{record, std::move(present->creation)};
  next.record.owner = std::move(present->record.owner);
  next.record.created_utc_ms = present->record.created_utc_ms;
  return Append(std::move(next));
}

Result<WriteOutcome> SqliteStore::DoDelete(const RoomId& room, const AnchorId& id,
                                           std::uint64_t expected_revision) {
  WAYMARK_TRY_ASSIGN(auto present, writer_.tables->FindState(room, id));
  if (!present || present->is_deleted || present->record.revision != expected_revision) {
    return {ConflictWith(std::move(present))};
  }
  return Append({std::move(present->record), {}, true});
}

std::vector<Result<WriteOutcome>> SqliteStore::Commit(
    const std::vector<const CommitQueue::Write*>& writes) {
  SqlSession& session = *writer_.session;
  std::vector<Result<WriteOutcome>> outcomes;
  if (failed_to_sync_) {
    return {writes.size(), MakeError(ErrorCode::kUnavailable,
                                     "{}: an earlier write could not be synced to disk; reopen the "
                                     "store to see what the disk kept",
                                     file_.string())};
  }
  const auto committed = session.Guard([&]() -> Result<void> {
    session.sql() << "BEGIN IMMEDIATE";
    for (const CommitQueue::Write* write : writes) outcomes.push_back((*write)());
    session.sql() << "COMMIT";
    return {};
  });
  if (committed) return outcomes;
  failed_to_sync_ = session.failed_to_sync();
  // SQLite may have rolled back by itself; then this fails and changes nothing.
  (void)session.Guard([&]() -> Result<void> {
    session.sql() << "ROLLBACK";
    return {};
  });
  return {writes.size(), committed.error()};
}

Result<Connection> SqliteStore::BorrowReader() {
  {
    const std::lock_guard lock(readers_mutex_);
    if (!idle_readers_.empty()) {
      Connection reader = std::move(idle_readers_.back());
      idle_readers_.pop_back();
      return reader;
    }
  }
  SqliteStoreOptions options = options_;
  options.mode = OpenMode::kExisting;
  return Connection::Open(file_, options);
}

void SqliteStore::ReturnReader(Connection reader) {
  constexpr std::size_t kMaxIdleReaders = 8;  // file handles and page caches, 2 MB each
  const std::lock_guard lock(readers_mutex_);
  if (idle_readers_.size() < kMaxIdleReaders) idle_readers_.push_back(std::move(reader));
}

}  // namespace

Result<void> SqliteStoreOptions::Validate() const {
  if (busy_timeout_s < 0 || busy_timeout_s > 3600) {
    return MakeError(ErrorCode::kInvalidArgument, "busy_timeout_s: expected 0 to 3600, found {}",
                     busy_timeout_s);
  }
  return {};
}

Result<std::unique_ptr<AnchorStore>> OpenSqliteStore(const std::filesystem::path& file,
                                                     const SqliteStoreOptions& options) {
  WAYMARK_TRY_ASSIGN(auto writer, Connection::Open(file, options));
  return {std::make_unique<SqliteStore>(file, options, std::move(writer))};
}

}  // namespace waymark::content
