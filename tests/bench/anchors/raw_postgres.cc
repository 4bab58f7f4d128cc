// SPDX-License-Identifier: Apache-2.0
#include <libpq-fe.h>

#include <cstdlib>
#include <mutex>

#include "content_store/internal/postgres_arrays.h"
#include "content_store/internal/record_codec.h"
#include "mapping/base/check.h"
#include "tests/bench/anchors/raw_store.h"

namespace waymark::bench {
namespace {

using content::internal::PostgresArray;

/// The fastest way to insert a group by hand that keeps to plain SQL: one statement with arrays.
class RawPostgres final : public RawStore {
 public:
  explicit RawPostgres(const std::string& uri) : connection_(PQconnectdb(uri.c_str())) {
    CHECK(PQstatus(connection_) == CONNECTION_OK, "{}", PQerrorMessage(connection_));
    Run("SET jit = off");
    Run("SET enable_seqscan = off");
    Run("DROP TABLE IF EXISTS raw_anchors");
    Run("CREATE TABLE raw_anchors (n bigserial PRIMARY KEY, room text COLLATE \"C\", id text "
        "COLLATE \"C\", latitude double precision, longitude double precision, record bytea)");
    Run("CREATE UNIQUE INDEX raw_by_id ON raw_anchors (room, id)");
    Run("CREATE INDEX raw_by_place ON raw_anchors (room, latitude, longitude)");
    Prepare("insert",
            "INSERT INTO raw_anchors (room, id, latitude, longitude, record) SELECT "
            "convert_from(decode(n.room, 'hex'), 'UTF8'), convert_from(decode(n.id, 'hex'), "
            "'UTF8'), n.latitude, n.longitude, decode(n.record, 'hex') FROM unnest($1::text[], "
            "$2::text[], $3::float8[], $4::float8[], $5::text[]) AS n(room, id, latitude, "
            "longitude, record)");
    Prepare("near",
            "SELECT latitude, longitude, encode(record, 'hex') FROM raw_anchors WHERE room = $1 "
            "AND latitude BETWEEN $2 AND $3 AND longitude BETWEEN $4 AND $5");
  }
  ~RawPostgres() override { PQfinish(connection_); }

  void Create(std::span<const content::AnchorRecord> records) override {
    PostgresArray rooms, ids, states;
    std::string latitudes = "{", longitudes = "{";
    for (const content::AnchorRecord& record : records) {
      rooms.AddHex(record.room.text());
      ids.AddHex(record.id.text());
      states.AddHex(content::internal::EncodeState({.record = record}));
      const char* const comma = latitudes.size() > 1 ? "," : "";
      latitudes += fmt::format("{}{}", comma, record.place.latitude.degrees());
      longitudes += fmt::format("{}{}", comma, record.place.longitude.degrees());
    }
    const std::lock_guard lock(mutex_);
    PQclear(Execute("insert",
                    {rooms.Text(), ids.Text(), latitudes + "}", longitudes + "}", states.Text()}));
  }

  std::vector<std::string> FindNear(const RoomId& room, const GeoPoint& centre,
                                    double radius_m) override {
    const DegreeBox box = BoxAround(centre, radius_m);
    const std::lock_guard lock(mutex_);
    PGresult* const result =
        Execute("near", {room.text(), fmt::format("{}", box.south), fmt::format("{}", box.north),
                         fmt::format("{}", box.west), fmt::format("{}", box.east)});
    NearRows rows(centre, radius_m);
    for (int i = 0; i < PQntuples(result); ++i) {
      rows.Add(std::strtod(PQgetvalue(result, i, 0), nullptr),
               std::strtod(PQgetvalue(result, i, 1), nullptr),
               content::internal::FindHexBytes(PQgetvalue(result, i, 2)).value());
    }
    PQclear(result);
    return std::move(rows).Take();
  }

 private:
  void Run(const char* statement) { PQclear(Checked(PQexec(connection_, statement))); }
  void Prepare(const char* name, const char* text) {
    PQclear(Checked(PQprepare(connection_, name, text, 0, nullptr)));
  }
  PGresult* Execute(const char* name, const std::vector<std::string>& parameters) {
    std::vector<const char*> values;
    for (const std::string& parameter : parameters) values.push_back(parameter.c_str());
    return Checked(PQexecPrepared(connection_, name, static_cast<int>(values.size()), values.data(),
                                  nullptr, nullptr, 0));
  }
  PGresult* Checked(PGresult* result) {
    const ExecStatusType status = PQresultStatus(result);
    CHECK(status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK, "{}",
          PQerrorMessage(connection_));
    return result;
  }

  std::mutex mutex_;
  PGconn* const connection_;  // guarded by mutex_
};

}  // namespace

std::unique_ptr<RawStore> OpenRawPostgres(const std::string& uri) {
  return std::make_unique<RawPostgres>(uri);
}

}  // namespace waymark::bench
