// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/postgres_tables.h"

#include <soci/soci.h>

#include <atomic>

#include "content_store/internal/postgres_schema.h"
#include "content_store/internal/postgres_session.h"
#include "content_store/internal/postgres_statements.h"
#include "content_store/internal/sql_numbers.h"

namespace waymark::content::internal {
namespace {

using soci::into;
using soci::use;

class PostgresTables final : public AnchorTables {
 public:
  explicit PostgresTables(std::unique_ptr<PostgresSession> session)
      : session_(std::move(session)), statements_(session_->sql()) {}

  const std::string& name() const override { return session_->name(); }
  Error Describe(const std::exception& exception) const override {
    return DescribePostgres(name(), exception);
  }
  ConnectionState state() override { return session_->state(); }

  void BeginRead() override { sql() << "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY"; }
  void BeginWrite() override {
    sql() << "BEGIN ISOLATION LEVEL READ COMMITTED";
    LockPostgresWriters(sql());
  }
  void Commit() override { sql() << "COMMIT"; }
  void Rollback() override { sql() << "ROLLBACK"; }

  std::uint64_t LatestRevision() override { return statements_.Latest(); }
  std::vector<LogRow> FindLatest(const std::vector<AnchorKey>& keys) override {
    return keys.empty() ? std::vector<LogRow>() : statements_.FindLatest(keys);
  }
  std::vector<LogRow> LoadStates(const std::vector<std::uint64_t>& revisions) override {
    return statements_.LoadStates(revisions);
  }
  std::vector<Position> FindPlaces(const Scan& scan) override {
    return statements_.FindPlaces(scan);
  }
  std::vector<LogRow> LoadLog(const std::optional<RoomId>& room, std::uint64_t after,
                              std::size_t limit) override {
    return room ? statements_.LoadRoomLog(*room, after, limit) : statements_.LoadLog(after, limit);
  }
  void AppendLog(const std::vector<LogRow>& rows) override { statements_.Append(rows); }
  void PutPlaces(const std::vector<PlaceRow>& places) override { statements_.Put(places); }
  std::map<OwnerKey, Usage> FindUsage(const std::vector<OwnerKey>& owners) override {
    return owners.empty() ? std::map<OwnerKey, Usage>() : statements_.FindUsage(owners);
  }
  void PutUsage(const std::map<OwnerKey, Usage>& usage) override { statements_.PutUsage(usage); }
  void Announce(std::uint64_t revision) override { statements_.Announce(revision); }
  bool AwaitAnnouncement(std::chrono::milliseconds timeout) override {
    if (!listens_) session_->Listen();
    listens_ = true;
    session_->AwaitAnnouncement(timeout);
    return true;
  }

  Compaction LoadCompaction() override;
  std::vector<std::uint64_t> ListRoom(const RoomId& room) override;
  std::vector<std::uint64_t> FindReplaced(const std::optional<RoomId>& room, std::uint64_t since,
                                          std::size_t limit) override;
  std::vector<RoomSummary> ListRooms() override;
  std::vector<PlaceRow> FindExpired(std::int64_t now_utc_ms, std::size_t limit) override;
  std::vector<PlaceRow> ListPlaces(const std::optional<AnchorKey>& after,
                                   std::size_t limit) override;
  std::map<OwnerKey, Usage> ListUsage() override;
  std::uint64_t CountLog(std::uint64_t after, std::uint64_t through) override;
  void RemoveSuperseded(std::uint64_t after, std::uint64_t through) override;
  void StoreCompaction(const Compaction& compaction) override;
  void Vacuum() override;
  /// What a check could ask of PostgreSQL needs an extension; our own checks read every row.
  std::vector<std::string> CheckStructure() override { return {}; }

 private:
  soci::session& sql() { return session_->sql(); }
  std::vector<std::uint64_t> FetchRevisions(soci::statement& statement, const long long& revision);

  const std::unique_ptr<PostgresSession> session_;
  PostgresStatements statements_;  // goes before the session
  bool listens_ = false;
};

std::vector<std::uint64_t> PostgresTables::FetchRevisions(soci::statement& statement,
                                                          const long long& revision) {
  std::vector<std::uint64_t> revisions;
  statement.execute();
  while (statement.fetch()) revisions.push_back(static_cast<std::uint64_t>(revision));
  return revisions;
}

Compaction PostgresTables::LoadCompaction() {
  long long through = 0, rows = 0;
  sql() << "SELECT coalesce(max(value) FILTER (WHERE name = 'compacted_through'), 0), "
           "coalesce(max(value) FILTER (WHERE name = 'compacted_rows'), 0) FROM waymark.facts",
      into(through), into(rows);
  return {static_cast<std::uint64_t>(through), static_cast<std::uint64_t>(rows)};
}

std::vector<std::uint64_t> PostgresTables::ListRoom(const RoomId& room) {
  long long revision = 0;
  const std::string name = room.text();
  soci::statement list = (sql().prepare << "SELECT revision FROM waymark.places WHERE room = :room "
                                           "AND cell IS NOT NULL ORDER BY id",
                          use(name), into(revision));
  return FetchRevisions(list, revision);
}

std::vector<std::uint64_t> PostgresTables::FindReplaced(const std::optional<RoomId>& room,
                                                        std::uint64_t since, std::size_t limit) {
  long long revision = 0;
  const long long then = Clamp(since), most = Clamp(limit);
  const std::string name = room ? room->text() : "";
  const char* const where = room ? "room = :room" : "CAST(:room AS text) = ''";
  soci::statement replaced =
      (sql().prepare << "SELECT previous FROM waymark.states WHERE " << where
                     << " AND revision > :since AND previous BETWEEN 1 AND :then LIMIT :limit",
       use(name), use(then), use(then), use(most), into(revision));
  return FetchRevisions(replaced, revision);
}

std::vector<RoomSummary> PostgresTables::ListRooms() {
  std::string room;
  long long anchors = 0, revision = 0;
  soci::statement rooms = (sql().prepare << "SELECT room, count(cell), max(revision) FROM "
                                            "waymark.places GROUP BY room ORDER BY room",
                           into(room), into(anchors), into(revision));
  std::vector<RoomSummary> summaries;
  rooms.execute();
  while (rooms.fetch()) {
    summaries.push_back(
        {RoomId(room), static_cast<std::size_t>(anchors), static_cast<std::uint64_t>(revision)});
  }
  return summaries;
}

std::vector<PlaceRow> PostgresTables::FindExpired(std::int64_t now_utc_ms, std::size_t limit) {
  std::string room, id;
  long long revision = 0;
  const long long now = now_utc_ms, most = Clamp(limit);
  soci::statement due =
      (sql().prepare << "SELECT room, id, revision FROM waymark.places WHERE expires IS NOT NULL "
                        "AND expires <= :now ORDER BY expires LIMIT :limit",
       use(now), use(most), into(room), into(id), into(revision));
  std::vector<PlaceRow> places;
  due.execute();
  while (due.fetch()) {
    places.push_back(
        {.key = {RoomId(room), AnchorId(id)}, .revision = static_cast<std::uint64_t>(revision)});
  }
  return places;
}

std::vector<PlaceRow> PostgresTables::ListPlaces(const std::optional<AnchorKey>& after,
                                                 std::size_t limit) {
  const std::string after_room = after ? after->room.text() : "";
  const std::string after_id = after ? after->id.text() : "";
  const long long most = Clamp(limit);
  std::string room, id;
  long long revision = 0, values[3] = {};
  int is_public = 0;
  soci::indicator has[3] = {};
  soci::statement list =
      (sql().prepare << "SELECT room, id, revision, cell, changed, expires, CAST(is_public AS "
                        "integer) FROM waymark.places WHERE (room, id) > (:room, :id) ORDER BY "
                        "room, id LIMIT :limit",
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

std::map<OwnerKey, Usage> PostgresTables::ListUsage() {
  std::map<OwnerKey, Usage> usage;
  std::string room, owner;
  long long anchors = 0, bytes = 0;
  soci::statement list = (sql().prepare << "SELECT room, owner, anchors, bytes FROM waymark.usage",
                          into(room), into(owner), into(anchors), into(bytes));
  list.execute();
  while (list.fetch()) usage[{room, owner}] = {anchors, bytes};
  return usage;
}

std::uint64_t PostgresTables::CountLog(std::uint64_t after, std::uint64_t through) {
  long long rows = 0;
  const long long first = Clamp(after), last = Clamp(through);
  sql() << "SELECT count(*) FROM waymark.states WHERE revision > :first AND revision <= :last",
      use(first), use(last), into(rows);
  return static_cast<std::uint64_t>(rows);
}

void PostgresTables::RemoveSuperseded(std::uint64_t after, std::uint64_t through) {
  const long long first = Clamp(after), last = Clamp(through);
  sql() << "DELETE FROM waymark.states s WHERE s.revision > :first AND s.revision <= :last AND NOT "
           "EXISTS (SELECT 1 FROM waymark.places p WHERE p.room = s.room AND p.id = s.id AND "
           "p.revision = s.revision)",
      use(first), use(last);
}

void PostgresTables::StoreCompaction(const Compaction& compaction) {
  const long long through = Clamp(compaction.through), rows = Clamp(compaction.rows);
  sql() << "INSERT INTO waymark.facts (name, value) VALUES ('compacted_through', :through), "
           "('compacted_rows', :rows) ON CONFLICT (name) DO UPDATE SET value = excluded.value",
      use(through), use(rows);
}

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
