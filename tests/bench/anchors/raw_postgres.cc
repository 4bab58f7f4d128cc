// SPDX-License-Identifier: Apache-2.0
#include <libpq-fe.h>

#include <cstdlib>
#include <vector>

#include "content_store/internal/postgres_binary.h"
#include "content_store/internal/record_codec.h"
#include "mapping/base/check.h"
#include "tests/bench/anchors/raw_store.h"

namespace waymark::bench {
namespace {

using content::internal::BinaryArray;

class Connection {
 public:
  explicit Connection(const std::string& uri) : connection_(PQconnectdb(uri.c_str())) {
    CHECK(PQstatus(connection_) == CONNECTION_OK, "{}", PQerrorMessage(connection_));
    for (const char* setting :
         {"SET jit = off", "SET enable_seqscan = off", "SET client_min_messages = warning",
          "SET plan_cache_mode = force_generic_plan"}) {
      Run(setting);
    }
  }
  ~Connection() { PQfinish(connection_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void Run(const char* statement) { Check(PQexec(connection_, statement)); }
  void Prepare(const char* text) { Check(PQprepare(connection_, "insert", text, 0, nullptr)); }
  std::uint64_t Count(const std::string& table) {
    PGresult* const result = PQexec(connection_, ("SELECT count(*) FROM " + table).c_str());
    const std::uint64_t count = std::strtoull(PQgetvalue(result, 0, 0), nullptr, 10);
    Check(result);
    return count;
  }
  /// Runs the prepared statement, which commits by itself.
  void Execute(const std::vector<std::string>& parameters) {
    std::vector<const char*> values;
    std::vector<int> lengths;
    for (const std::string& parameter : parameters) {
      values.push_back(parameter.data());
      lengths.push_back(static_cast<int>(parameter.size()));
    }
    const std::vector<int> formats(parameters.size(), 1);
    Check(PQexecPrepared(connection_, "insert", static_cast<int>(parameters.size()), values.data(),
                         lengths.data(), formats.data(), 1));
  }

 private:
  void Check(PGresult* result) {
    const ExecStatusType status = PQresultStatus(result);
    CHECK(status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK, "{}",
          PQerrorMessage(connection_));
    PQclear(result);
  }

  PGconn* const connection_;
};

/// The columns of a group, as arrays.
struct Columns {
  explicit Columns(std::span<const content::AnchorRecord> records) {
    for (const content::AnchorRecord& record : records) {
      rooms.Add(record.room.text());
      ids.Add(record.id.text());
      // A place in nanodegrees: integers are what a B-tree compares fastest.
      latitudes.Add(static_cast<std::int64_t>(1e9 * record.place.latitude.degrees()));
      longitudes.Add(static_cast<std::int64_t>(1e9 * record.place.longitude.degrees()));
      states.Add(content::internal::EncodeState({.record = record}));
      owners.Add(record.owner);
      changed.Add(record.changed_utc_ms);
      expires.Add(record.expires_utc_ms);
      bytes.Add(std::ssize(record.payload));
    }
  }
  BinaryArray rooms{BinaryArray::kText}, ids{BinaryArray::kText}, owners{BinaryArray::kText};
  BinaryArray latitudes{BinaryArray::kNumber}, longitudes{BinaryArray::kNumber};
  BinaryArray changed{BinaryArray::kNumber}, expires{BinaryArray::kNumber};
  BinaryArray bytes{BinaryArray::kNumber}, states{BinaryArray::kBytes};
};

class RowStore final : public RawStore {
 public:
  explicit RowStore(const std::string& uri) : connection_(uri) {
    connection_.Run(
        "CREATE TABLE IF NOT EXISTS raw_anchors (n bigserial PRIMARY KEY, room text COLLATE "
        "\"C\", id text COLLATE \"C\", latitude bigint, longitude bigint, record bytea); CREATE "
        "UNIQUE INDEX IF NOT EXISTS raw_by_id ON raw_anchors (room, id); CREATE INDEX IF NOT "
        "EXISTS raw_by_place ON raw_anchors (room, latitude, longitude)");
    connection_.Prepare(
        "INSERT INTO raw_anchors (room, id, latitude, longitude, record) SELECT * FROM "
        "unnest($1::text[], $2::text[], $3::bigint[], $4::bigint[], $5::bytea[])");
  }

  void Create(std::span<const content::AnchorRecord> records) override {
    Columns all(records);
    connection_.Execute({std::move(all.rooms).Take(), std::move(all.ids).Take(),
                         std::move(all.latitudes).Take(), std::move(all.longitudes).Take(),
                         std::move(all.states).Take()});
  }
  std::uint64_t Count() override { return connection_.Count("raw_anchors"); }

 private:
  Connection connection_;
};

class SameStore final : public RawStore {
 public:
  explicit SameStore(const std::string& uri) : connection_(uri) {
    connection_.Run(
        "CREATE TABLE IF NOT EXISTS same_counter (value bigint NOT NULL); INSERT INTO same_counter "
        "SELECT 0 WHERE NOT EXISTS (SELECT FROM same_counter); "
        "CREATE TABLE IF NOT EXISTS same_anchors (room text COLLATE \"C\", id text COLLATE \"C\", "
        "revision "
        "bigint, latitude bigint, longitude bigint, changed bigint, expires bigint, record bytea, "
        "PRIMARY KEY (room, id)); "
        "CREATE INDEX IF NOT EXISTS same_by_place ON same_anchors (room, latitude, longitude); "
        "CREATE INDEX IF NOT EXISTS same_by_change ON same_anchors (room, changed); "
        "CREATE INDEX IF NOT EXISTS same_by_expiry ON same_anchors (expires) WHERE expires IS NOT "
        "NULL; "
        "CREATE TABLE IF NOT EXISTS same_changes (revision bigint PRIMARY KEY, room text COLLATE "
        "\"C\", id text COLLATE \"C\"); CREATE INDEX IF NOT EXISTS same_changes_by_room ON "
        "same_changes (room, revision); "
        "CREATE TABLE IF NOT EXISTS same_owned (room text COLLATE \"C\", owner text COLLATE \"C\", "
        "anchors "
        "bigint, bytes bigint, PRIMARY KEY (room, owner))");
    connection_.Prepare(
        "WITH taken AS (UPDATE same_counter SET value = value + $10::bigint RETURNING value - "
        "$10::bigint AS base), given AS (SELECT * FROM unnest($1::text[], $2::text[], "
        "$3::bigint[], $4::bigint[], $5::bytea[], $6::text[], $7::bigint[], $8::bigint[], "
        "$9::bigint[]) WITH ORDINALITY AS g(room, id, latitude, longitude, record, owner, changed, "
        "expires, bytes, n)), put AS (INSERT INTO same_anchors (room, id, revision, latitude, "
        "longitude, changed, expires, record) SELECT room, id, base + n, latitude, longitude, "
        "changed, expires, record FROM given, taken ON CONFLICT (room, id) DO NOTHING RETURNING "
        "revision, room, id), logged AS (INSERT INTO same_changes SELECT * FROM put), owned AS "
        "(INSERT INTO same_owned AS o SELECT room, owner, count(*), sum(bytes) FROM given GROUP BY "
        "room, owner ON CONFLICT (room, owner) DO UPDATE SET anchors = o.anchors + "
        "excluded.anchors, bytes = o.bytes + excluded.bytes) SELECT pg_notify('same', base::text) "
        "FROM taken");
  }

  void Create(std::span<const content::AnchorRecord> records) override {
    Columns all(records);
    connection_.Execute(
        {std::move(all.rooms).Take(), std::move(all.ids).Take(), std::move(all.latitudes).Take(),
         std::move(all.longitudes).Take(), std::move(all.states).Take(),
         std::move(all.owners).Take(), std::move(all.changed).Take(), std::move(all.expires).Take(),
         std::move(all.bytes).Take(), content::internal::ToBinary(std::ssize(records))});
  }
  std::uint64_t Count() override { return connection_.Count("same_anchors"); }

 private:
  Connection connection_;
};

}  // namespace

std::unique_ptr<RawStore> OpenRawPostgres(const std::string& uri, Facts facts) {
  if (facts == Facts::kRow) return std::make_unique<RowStore>(uri);
  return std::make_unique<SameStore>(uri);
}

}  // namespace waymark::bench
