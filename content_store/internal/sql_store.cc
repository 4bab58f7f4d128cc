// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/sql_store.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <mutex>

#include "content_store/anchor_rules.h"
#include "content_store/internal/anchor_reads.h"
#include "content_store/internal/commit_queue.h"
#include "content_store/internal/connection_pool.h"
#include "content_store/internal/nearest.h"
#include "content_store/internal/paged_query.h"
#include "content_store/internal/store_writer.h"

namespace waymark::content::internal {
namespace {

class SqlStore final : public AnchorStore {
 public:
  SqlStore(std::unique_ptr<AnchorDatabase> database, const StoreOptions& options,
           std::unique_ptr<AnchorTables> writer)
      : database_(std::move(database)),
        options_(options),
        readers_(*database_),
        listeners_(*database_),
        writer_(*database_, options_, std::move(writer)) {}

  Result<WriteOutcome> Create(const AnchorRecord& record) override {
    WAYMARK_TRY(Validate(record));
    return RunOne({WriteKind::kCreate, record});
  }
  std::vector<Result<WriteOutcome>> CreateMany(std::span<const AnchorRecord> records) override {
    return WriteMany(WriteKind::kCreate, records);
  }
  std::vector<Result<WriteOutcome>> UpdateMany(std::span<const AnchorRecord> records) override {
    return WriteMany(WriteKind::kUpdate, records);
  }
  Result<WriteOutcome> Update(const AnchorRecord& record,
                              std::uint64_t expected_revision) override {
    WAYMARK_TRY(Validate(record));
    return RunOne({WriteKind::kUpdate, record, expected_revision});
  }
  Result<WriteOutcome> Move(const AnchorMove& move, std::uint64_t expected_revision) override {
    const AnchorRecord record{.id = move.id,
                              .room = move.room,
                              .map_from_anchor = move.map_from_anchor,
                              .epoch = move.epoch,
                              .attachments = move.attachments,
                              .place = move.place,
                              .changed_utc_ms = move.changed_utc_ms};
    WAYMARK_TRY(Validate(record));
    return RunOne({WriteKind::kMove, record, expected_revision});
  }
  Result<WriteOutcome> Delete(const RoomId& room, const AnchorId& id,
                              std::uint64_t expected_revision) override {
    const AnchorRecord record{.id = id, .room = room};
    return RunOne({WriteKind::kDelete, record, expected_revision});
  }
  Result<std::size_t> Expire(std::int64_t now_utc_ms, std::size_t limit) override;

  Result<std::optional<AnchorRecord>> Find(const RoomId& room, const AnchorId& id) override {
    if (!IsText(room.text()) || !IsText(id.text())) return std::optional<AnchorRecord>();
    return readers_.Read([&](AnchorTables& tables) { return FindAnchor(tables, {room, id}); });
  }
  Result<RoomSnapshot> LoadRoom(const RoomId& room) override {
    if (!IsText(room.text())) return RoomSnapshot{};
    return readers_.Read([&](AnchorTables& tables) { return LoadSnapshot(tables, room); });
  }
  Result<std::vector<RoomSummary>> ListRooms() override {
    return readers_.Read([](AnchorTables& tables) -> Result<std::vector<RoomSummary>> {
      return tables.ListRooms();
    });
  }
  Result<AnchorPage> Query(const AnchorQuery& query) override {
    WAYMARK_TRY(query.Validate());
    if (query.room && !IsText(query.room->text())) return AnchorPage{};
    return readers_.Read([&](AnchorTables& tables) { return FindPage(tables, query); });
  }
  Result<std::vector<AnchorRecord>> FindNear(const RoomId& room, const GeoPoint& centre,
                                             double radius_m, std::size_t limit) override {
    WAYMARK_TRY(centre.Validate());
    if (!std::isfinite(radius_m) || radius_m < 0) {
      return MakeError(ErrorCode::kInvalidArgument, "radius: expected at least 0 m, found {}",
                       radius_m);
    }
    if (limit == 0 || !IsText(room.text())) return std::vector<AnchorRecord>();
    return readers_.Read(
        [&](AnchorTables& tables) { return FindNearest(tables, room, centre, radius_m, limit); });
  }
  Result<std::vector<AnchorChange>> LoadChanges(std::uint64_t after_revision,
                                                std::size_t limit) override {
    return readers_.Read([&](AnchorTables& tables) {
      return FindChanges(tables, std::nullopt, after_revision, limit);
    });
  }
  Result<std::vector<AnchorChange>> LoadRoomChanges(const RoomId& room,
                                                    std::uint64_t after_revision,
                                                    std::size_t limit) override {
    if (!IsText(room.text())) return std::vector<AnchorChange>();
    return readers_.Read(
        [&](AnchorTables& tables) { return FindChanges(tables, room, after_revision, limit); });
  }
  Result<std::uint64_t> WaitForChanges(std::uint64_t after_revision,
                                       std::chrono::milliseconds timeout) override;

 private:
  Result<WriteOutcome> RunOne(const WriteRequest& request) {
    return std::move(queue_.Run({&request, 1}).front());
  }
  std::vector<Result<WriteOutcome>> WriteMany(WriteKind kind,
                                              std::span<const AnchorRecord> records);
  std::vector<Result<WriteOutcome>> Commit(const std::vector<const WriteRequest*>& requests);

  const std::unique_ptr<AnchorDatabase> database_;
  const StoreOptions options_;
  ConnectionPool readers_, listeners_;
  StoreWriter writer_;  // used by the committing thread only
  CommitQueue queue_{[this](const auto& requests) { return Commit(requests); }};
  std::mutex committed_mutex_;
  std::condition_variable committed_;
  std::uint64_t commits_ = 0;  // guarded by committed_mutex_
};

std::vector<Result<WriteOutcome>> SqlStore::WriteMany(WriteKind kind,
                                                      std::span<const AnchorRecord> records) {
  constexpr std::size_t kMaxRequests = 1024, kMaxBytes = std::size_t{4} << 20;
  std::vector<Result<WriteOutcome>> outcomes;
  outcomes.reserve(records.size());
  for (std::size_t begin = 0; begin < records.size();) {
    std::vector<WriteRequest> requests;
    std::size_t bytes = 0;
    const std::size_t first = begin;
    for (; begin < records.size() && requests.size() < kMaxRequests && bytes < kMaxBytes; ++begin) {
      const auto valid = Validate(records[begin]);
      outcomes.push_back(valid ? Result<WriteOutcome>(WriteConflict{}) : valid.error());
      if (!valid) continue;
      bytes += records[begin].payload.size();
      requests.push_back({kind, records[begin], records[begin].revision, false});
    }
    auto written = queue_.Run(requests);
    auto next = written.begin();
    for (std::size_t i = first; i < begin; ++i) {
      if (outcomes[i]) outcomes[i] = std::move(*next++);
    }
  }
  return outcomes;
}

Result<std::size_t> SqlStore::Expire(std::int64_t now_utc_ms, std::size_t limit) {
  constexpr std::size_t kMaxAtOnce = 256;
  std::size_t deleted = 0;
  while (deleted < limit) {
    WAYMARK_TRY_ASSIGN(
        const auto due, readers_.Read([&](AnchorTables& tables) -> Result<std::vector<PlaceRow>> {
          return tables.FindExpired(now_utc_ms, std::min(kMaxAtOnce, limit - deleted));
        }));
    if (due.empty()) break;
    std::deque<AnchorRecord> records;
    std::vector<WriteRequest> requests;
    for (const PlaceRow& place : due) {
      records.push_back({.id = place.key.id, .room = place.key.room});
      requests.push_back({WriteKind::kDelete, records.back(), place.revision, false});
    }
    std::size_t applied = 0;
    for (const auto& outcome : queue_.Run(requests)) {
      if (!outcome) return outcome.error();
      applied += std::holds_alternative<AnchorRecord>(*outcome) ? 1 : 0;
    }
    deleted += applied;
    if (applied == 0) break;  // another server does the same; what is left comes with the next call
  }
  return deleted;
}

std::vector<Result<WriteOutcome>> SqlStore::Commit(
    const std::vector<const WriteRequest*>& requests) {
  auto outcomes = writer_.Commit(requests);
  if (writer_.has_written()) {
    const std::lock_guard lock(committed_mutex_);
    ++commits_;
    committed_.notify_all();
  }
  return outcomes;
}

Result<std::uint64_t> SqlStore::WaitForChanges(std::uint64_t after_revision,
                                               std::chrono::milliseconds timeout) {
  // How long a commit of another process may go unseen where nobody announces it.
  constexpr auto kLook = std::chrono::milliseconds(20);
  const auto end = std::chrono::steady_clock::now() + timeout;
  return listeners_.Use([&](AnchorTables& tables) -> Result<std::uint64_t> {
    for (;;) {
      std::unique_lock lock(committed_mutex_);
      const std::uint64_t commits = commits_;
      lock.unlock();
      // First listening, then looking: what comes after the look is announced.
      const bool listens = tables.AwaitAnnouncement(std::chrono::milliseconds(0));
      const std::uint64_t latest = tables.LatestRevision();
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
          end - std::chrono::steady_clock::now());
      if (latest > after_revision || left.count() <= 0) return latest;
      if (listens) {
        (void)tables.AwaitAnnouncement(left);
      } else {
        lock.lock();
        committed_.wait_for(lock, std::min(left, kLook), [&] { return commits_ != commits; });
      }
    }
  });
}

}  // namespace

Result<std::unique_ptr<AnchorStore>> OpenSqlStore(std::unique_ptr<AnchorDatabase> database,
                                                  const StoreOptions& options) {
  WAYMARK_TRY_ASSIGN(auto writer, database->Connect());
  return {std::make_unique<SqlStore>(std::move(database), options, std::move(writer))};
}

}  // namespace waymark::content::internal
