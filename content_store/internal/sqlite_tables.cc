// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/sqlite_tables.h"

#include <soci/soci.h>

#include <atomic>

#include "content_store/internal/sql_numbers.h"
#include "content_store/internal/sqlite_session.h"
#include "content_store/internal/sqlite_statements.h"

namespace waymark::content::internal {
namespace {

using soci::into;
using soci::use;

class SqliteTables final : public AnchorTables {
 public:
  explicit SqliteTables(std::unique_ptr<SqliteSession> session)
      : session_(std::move(session)), statements_(session_->sql()) {}

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
    for (const std::uint64_t revision : revisions) statements_.AddState(revision, rows);
    return rows;
  }
  std::vector<Position> FindPlaces(const Scan& scan) override {
    return statements_.FindPlaces(scan);
  }
  std::vector<LogRow> LoadLog(const std::optional<RoomId>& room, std::uint64_t after,
                              std::size_t limit) override {
    return room ? statements_.LoadRoomLog(*room, after, limit) : statements_.LoadLog(after, limit);
  }
  void AppendLog(const std::vector<LogRow>& rows) override {
    for (const LogRow& row : rows) statements_.Append(row);
  }
  void PutPlaces(const std::vector<PlaceRow>& places) override {
    for (const PlaceRow& place : places) statements_.Put(place);
  }
  void Announce(std::uint64_t) override {}
  bool AwaitAnnouncement(std::chrono::milliseconds) override { return false; }

  Compaction LoadCompaction() override;
  std::vector<std::uint64_t> ListRoom(const RoomId& room) override;
  std::vector<std::uint64_t> FindReplaced(const std::optional<RoomId>& room, std::uint64_t since,
                                          std::size_t limit) override;
  std::vector<RoomSummary> ListRooms() override;
  std::vector<PlaceRow> FindExpired(std::int64_t now_utc_ms, std::size_t limit) override;
  std::vector<PlaceRow> ListPlaces(const std::optional<AnchorKey>& after,
                                   std::size_t limit) override;
  std::map<OwnerKey, Usage> FindUsage(const std::vector<OwnerKey>& owners) override;
  std::map<OwnerKey, Usage> ListUsage() override;
  std::uint64_t CountLog(std::uint64_t after, std::uint64_t through) override;
  void PutUsage(const std::map<OwnerKey, Usage>& usage) override {
    for (const auto& [owner, owned] : usage) statements_.PutUsage(owner, owned);
  }
  void RemoveSuperseded(std::uint64_t after, std::uint64_t through) override;
  void StoreCompaction(const Compaction& compaction) override;
  void Vacuum() override;
  std::vector<std::string> CheckStructure() override;

 private:
  soci::session& sql() { return session_->sql(); }
  std::vector<std::uint64_t> FetchRevisions(soci::statement& statement, const long long& revision);

  const std::unique_ptr<SqliteSession> session_;
  SqliteStatements statements_;  // goes before the session
};

std::vector<std::uint64_t> SqliteTables::FetchRevisions(soci::statement& statement,
                                                        const long long& revision) {
  std::vector<std::uint64_t> revisions;
  statement.execute();
  while (statement.fetch()) revisions.push_back(static_cast<std::uint64_t>(revision));
  return revisions;
}

Compaction SqliteTables::LoadCompaction() {
  long long through = 0, rows = 0;
  sql() << "SELECT coalesce(max(value) FILTER (WHERE name = 'compacted_through'), 0), "
           "coalesce(max(value) FILTER (WHERE name = 'compacted_rows'), 0) FROM facts",
      into(through), into(rows);
  return {static_cast<std::uint64_t>(through), static_cast<std::uint64_t>(rows)};
}

std::vector<std::uint64_t> SqliteTables::ListRoom(const RoomId& room) {
  long long revision = 0;
  const std::string name = room.text();
  soci::statement list =
      (sql().prepare << "SELECT revision FROM places WHERE room = :room AND cell "
                        "IS NOT NULL ORDER BY id",
       use(name), into(revision));
  return FetchRevisions(list, revision);
}

std::vector<std::uint64_t> SqliteTables::FindReplaced(const std::optional<RoomId>& room,
                                                      std::uint64_t since, std::size_t limit) {
  long long revision = 0;
  const long long then = Clamp(since), most = Clamp(limit);
  if (!room) {
    soci::statement replaced =
        (sql().prepare
             << "SELECT previous FROM states WHERE revision > :since AND previous BETWEEN "
                "1 AND :then LIMIT :limit",
         use(then), use(then), use(most), into(revision));
    return FetchRevisions(replaced, revision);
  }
  const std::string name = room->text();
  soci::statement replaced =
      (sql().prepare << "SELECT previous FROM states WHERE room = :room AND revision > :since AND "
                        "previous BETWEEN 1 AND :then LIMIT :limit",
       use(name), use(then), use(then), use(most), into(revision));
  return FetchRevisions(replaced, revision);
}

std::vector<RoomSummary> SqliteTables::ListRooms() {
  std::string room;
  long long anchors = 0, revision = 0;
  soci::statement rooms = (sql().prepare << "SELECT room, count(cell), max(revision) FROM places "
                                            "GROUP BY room ORDER BY room",
                           into(room), into(anchors), into(revision));
  std::vector<RoomSummary> summaries;
  rooms.execute();
  while (rooms.fetch()) {
    summaries.push_back(
        {RoomId(room), static_cast<std::size_t>(anchors), static_cast<std::uint64_t>(revision)});
  }
  return summaries;
}

std::vector<PlaceRow> SqliteTables::FindExpired(std::int64_t now_utc_ms, std::size_t limit) {
  std::string room, id;
  long long revision = 0;
  const long long now = now_utc_ms, most = Clamp(limit);
  soci::statement due =
      (sql().prepare
           << "SELECT room, id, revision FROM places WHERE expires IS NOT NULL AND expires "
              "<= :now ORDER BY expires LIMIT :limit",
       use(now), use(most), into(room), into(id), into(revision));
  std::vector<PlaceRow> places;
  due.execute();
  while (due.fetch()) {
    places.push_back(
        {.key = {RoomId(room), AnchorId(id)}, .revision = static_cast<std::uint64_t>(revision)});
  }
  return places;
}

std::vector<PlaceRow> SqliteTables::ListPlaces(const std::optional<AnchorKey>& after,
                                               std::size_t limit) {
  const std::string after_room = after ? after->room.text() : "";
  const std::string after_id = after ? after->id.text() : "";
  const long long most = Clamp(limit);
  std::string room, id;
  long long revision = 0, is_public = 0, values[3] = {};
  soci::indicator has[3] = {};
  soci::statement list =
      (sql().prepare << "SELECT room, id, revision, cell, changed, expires, is_public FROM places "
                        "WHERE (room, id) > (:room, :id) ORDER BY room, id LIMIT :limit",
       use(after_room), use(after_id), use(most), into(room), into(id), into(revision),
       into(values[0], has[0]), into(values[1], has[1]), into(values[2], has[2]), into(is_public));
  const auto get = [&](int i) {
    return has[i] == soci::i_ok ? std::optional<std::int64_t>(values[i]) : std::nullopt;
  };
  std::vector<PlaceRow> places;
  list.execute();
  while (list.fetch()) {
    places.push_back({{RoomId(room), AnchorId(id)},
                      static_cast<std::uint64_t>(revision),
                      get(0),
                      get(1),
                      get(2),
                      is_public != 0});
  }
  return places;
}

std::map<OwnerKey, Usage> SqliteTables::FindUsage(const std::vector<OwnerKey>& owners) {
  std::map<OwnerKey, Usage> usage;
  for (const OwnerKey& owner : owners) {
    if (const auto found = statements_.FindUsage(owner)) usage.emplace(owner, *found);
  }
  return usage;
}

std::map<OwnerKey, Usage> SqliteTables::ListUsage() {
  std::map<OwnerKey, Usage> usage;
  std::string room, owner;
  long long anchors = 0, bytes = 0;
  soci::statement list = (sql().prepare << "SELECT room, owner, anchors, bytes FROM usage",
                          into(room), into(owner), into(anchors), into(bytes));
  list.execute();
  while (list.fetch()) usage[{room, owner}] = {anchors, bytes};
  return usage;
}

std::uint64_t SqliteTables::CountLog(std::uint64_t after, std::uint64_t through) {
  long long rows = 0;
  const long long first = Clamp(after), last = Clamp(through);
  sql() << "SELECT count(*) FROM states WHERE revision > :first AND revision <= :last", use(first),
      use(last), into(rows);
  return static_cast<std::uint64_t>(rows);
}

void SqliteTables::RemoveSuperseded(std::uint64_t after, std::uint64_t through) {
  const long long first = Clamp(after), last = Clamp(through);
  sql()
      << "DELETE FROM states WHERE revision > :first AND revision <= :last AND NOT EXISTS (SELECT "
         "1 FROM places p WHERE p.room = states.room AND p.id = states.id AND p.revision = "
         "states.revision)",
      use(first), use(last);
}

void SqliteTables::StoreCompaction(const Compaction& compaction) {
  const long long through = Clamp(compaction.through), rows = Clamp(compaction.rows);
  sql() << "INSERT INTO facts (name, value) VALUES ('compacted_through', :through), "
           "('compacted_rows', :rows) ON CONFLICT (name) DO UPDATE SET value = excluded.value",
      use(through), use(rows);
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
