// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/postgres_statements.h"

#include <stdexcept>

#include "content_store/internal/postgres_arrays.h"
#include "content_store/internal/sql_numbers.h"

namespace waymark::content::internal {
namespace {

using soci::into;
using soci::use;

/// A column of hex texts as the texts themselves.
std::string Text(const char* column) {
  return fmt::format("convert_from(decode({}, 'hex'), 'UTF8')", column);
}

std::string SelectStates(const std::string& from) {
  return "SELECT s.revision, s.previous, s.room, s.id, encode(s.state, 'hex'), s.checksum " + from;
}

/// All ranges in one round trip; each by its index and no farther than the limit. A range has one
/// lower end: where there are two, the index is read from the one that PostgreSQL happens to take.
std::string SelectPlaces(const std::string& key, const std::string& where) {
  return fmt::format(
      "SELECT p.{0}, p.revision FROM unnest(CAST(:firsts AS bigint[]), CAST(:afters AS bigint[]), "
      "CAST(:lasts AS bigint[])) AS r(first, after, last), LATERAL (SELECT {0}, revision FROM "
      "waymark.places WHERE {1} AND ({0}, revision) > (r.first, r.after) AND {0} <= r.last AND "
      "revision <= :newest ORDER BY {0}, revision LIMIT :most) AS p ORDER BY p.{0}, p.revision "
      "LIMIT :limit",
      key, where);
}

}  // namespace

PostgresStatements::PostgresStatements(soci::session& sql)
    : latest_((sql.prepare << "SELECT coalesce(max(revision), 0) FROM waymark.states",
               into(row_revision_))),
      find_((sql.prepare << "SELECT p.revision, coalesce(s.previous, 0), p.room, p.id, "
                            "coalesce(encode(s.state, 'hex'), ''), coalesce(s.checksum, 0) FROM "
                            "unnest(CAST(:rooms AS text[]), CAST(:ids AS text[])) AS k(room, id) "
                            "JOIN waymark.places p ON p.room = "
                         << Text("k.room") << " AND p.id = " << Text("k.id")
                         << " LEFT JOIN waymark.states s ON s.revision = p.revision",
             use(arrays_[0]), use(arrays_[1]), into(row_revision_), into(row_previous_),
             into(row_room_), into(row_id_), into(row_state_), into(row_checksum_))),
      load_((sql.prepare << SelectStates("FROM waymark.states s WHERE s.revision = "
                                         "ANY(CAST(:revisions AS bigint[]))"),
             use(arrays_[0]), into(row_revision_), into(row_previous_), into(row_room_),
             into(row_id_), into(row_state_), into(row_checksum_))),
      by_cell_((sql.prepare << SelectPlaces("cell", "room = :room"), use(arrays_[0]),
                use(arrays_[1]), use(arrays_[2]), use(room_), use(newest_), use(limit_),
                use(limit_), into(row_key_), into(row_revision_))),
      by_change_((sql.prepare << SelectPlaces("changed", "room = :room"), use(arrays_[0]),
                  use(arrays_[1]), use(arrays_[2]), use(room_), use(newest_), use(limit_),
                  use(limit_), into(row_key_), into(row_revision_))),
      public_by_cell_((sql.prepare << SelectPlaces("cell", "is_public"), use(arrays_[0]),
                       use(arrays_[1]), use(arrays_[2]), use(newest_), use(limit_), use(limit_),
                       into(row_key_), into(row_revision_))),
      log_((sql.prepare << SelectStates("FROM waymark.states s WHERE s.revision > :revision ORDER "
                                        "BY s.revision LIMIT :limit"),
            use(revision_), use(limit_), into(row_revision_), into(row_previous_), into(row_room_),
            into(row_id_), into(row_state_), into(row_checksum_))),
      room_log_((sql.prepare << SelectStates("FROM waymark.states s WHERE s.room = :room AND "
                                             "s.revision > :revision ORDER BY s.revision LIMIT "
                                             ":limit"),
                 use(room_), use(revision_), use(limit_), into(row_revision_), into(row_previous_),
                 into(row_room_), into(row_id_), into(row_state_), into(row_checksum_))),
      append_((sql.prepare << "INSERT INTO waymark.states (revision, previous, room, id, state, "
                              "checksum) SELECT n.revision, n.previous, "
                           << Text("n.room") << ", " << Text("n.id")
                           << ", decode(n.state, 'hex'), n.checksum FROM unnest(CAST(:a AS "
                              "bigint[]), CAST(:b AS bigint[]), CAST(:c AS text[]), CAST(:d AS "
                              "text[]), CAST(:e AS text[]), CAST(:f AS bigint[])) AS n(revision, "
                              "previous, room, id, state, checksum)",
               use(arrays_[0]), use(arrays_[1]), use(arrays_[2]), use(arrays_[3]), use(arrays_[4]),
               use(arrays_[5]))),
      put_((sql.prepare << "INSERT INTO waymark.places (room, id, revision, cell, changed, "
                           "expires, is_public) SELECT "
                        << Text("n.room") << ", " << Text("n.id")
                        << ", n.revision, n.cell, n.changed, n.expires, n.is_public <> 0 FROM "
                           "unnest(CAST(:a AS text[]), CAST(:b AS text[]), CAST(:c AS bigint[]), "
                           "CAST(:d AS bigint[]), CAST(:e AS bigint[]), CAST(:f AS bigint[]), "
                           "CAST(:g AS bigint[])) AS n(room, id, revision, cell, changed, expires, "
                           "is_public) ON CONFLICT (room, id) DO UPDATE SET revision = "
                           "excluded.revision, cell = excluded.cell, changed = excluded.changed, "
                           "expires = excluded.expires, is_public = excluded.is_public",
            use(arrays_[0]), use(arrays_[1]), use(arrays_[2]), use(arrays_[3]), use(arrays_[4]),
            use(arrays_[5]), use(arrays_[6]))),
      find_usage_((sql.prepare << "SELECT u.room, u.owner, u.anchors, u.bytes FROM unnest(CAST(:a "
                                  "AS text[]), CAST(:b AS text[])) AS k(room, owner) JOIN "
                                  "waymark.usage u ON u.room = "
                               << Text("k.room") << " AND u.owner = " << Text("k.owner"),
                   use(arrays_[0]), use(arrays_[1]), into(row_room_), into(row_id_),
                   into(row_revision_), into(row_previous_))),
      put_usage_((sql.prepare << "INSERT INTO waymark.usage (room, owner, anchors, bytes) SELECT "
                              << Text("n.room") << ", " << Text("n.owner")
                              << ", n.anchors, n.bytes FROM unnest(CAST(:a AS text[]), CAST(:b AS "
                                 "text[]), CAST(:c AS bigint[]), CAST(:d AS bigint[])) AS n(room, "
                                 "owner, anchors, bytes) ON CONFLICT (room, owner) DO UPDATE SET "
                                 "anchors = excluded.anchors, bytes = excluded.bytes",
                  use(arrays_[0]), use(arrays_[1]), use(arrays_[2]), use(arrays_[3]))),
      announce_(
          (sql.prepare << "SELECT pg_catalog.pg_notify('waymark_anchors', CAST(CAST(:revision "
                          "AS bigint) AS text))",
           use(revision_))) {}

std::uint64_t PostgresStatements::Latest() {
  latest_.execute(true);
  return static_cast<std::uint64_t>(row_revision_);
}

std::vector<LogRow> PostgresStatements::Fetch(soci::statement& statement) {
  std::vector<LogRow> rows;
  statement.execute();
  while (statement.fetch()) {
    std::optional<std::string> state = FindHexBytes(row_state_);
    if (!state) throw std::runtime_error("expected hex digits from the database");
    rows.push_back({.revision = static_cast<std::uint64_t>(row_revision_),
                    .previous = static_cast<std::uint64_t>(row_previous_),
                    .room = row_room_,
                    .id = row_id_,
                    .state = *std::move(state),
                    .checksum = row_checksum_});
  }
  return rows;
}

void PostgresStatements::Bind(std::initializer_list<const PostgresArray*> arrays) {
  std::size_t i = 0;
  for (const PostgresArray* array : arrays) arrays_[i++] = array->Text();
}

std::vector<LogRow> PostgresStatements::FindLatest(const std::vector<AnchorKey>& keys) {
  PostgresArray rooms, ids;
  for (const AnchorKey& key : keys) {
    rooms.AddHex(key.room.text());
    ids.AddHex(key.id.text());
  }
  Bind({&rooms, &ids});
  return Fetch(find_);
}

std::vector<LogRow> PostgresStatements::LoadStates(const std::vector<std::uint64_t>& revisions) {
  PostgresArray wanted;
  for (const std::uint64_t revision : revisions) wanted.Add(Clamp(revision));
  Bind({&wanted});
  return Fetch(load_);
}

std::vector<Position> PostgresStatements::FindPlaces(const Scan& scan) {
  if (scan.room) room_ = scan.room->text();
  PostgresArray firsts, afters, lasts;
  for (const auto& [first, last] : scan.ranges) {
    if (last < scan.after.key) continue;
    const bool has_begun = first <= scan.after.key;
    firsts.Add(has_begun ? scan.after.key : first);
    afters.Add(has_begun ? Clamp(scan.after.revision) : 0);  // revisions begin with 1
    lasts.Add(last);
  }
  Bind({&firsts, &afters, &lasts});
  newest_ = Clamp(scan.newest);
  limit_ = Clamp(scan.limit);
  soci::statement& statement = !scan.room                          ? public_by_cell_
                               : scan.order == ScanOrder::kChanged ? by_change_
                                                                   : by_cell_;
  std::vector<Position> positions;
  statement.execute();
  while (statement.fetch()) {
    positions.push_back({row_key_, static_cast<std::uint64_t>(row_revision_)});
  }
  return positions;
}

std::vector<LogRow> PostgresStatements::LoadLog(std::uint64_t after, std::size_t limit) {
  revision_ = Clamp(after);
  limit_ = Clamp(limit);
  return Fetch(log_);
}

std::vector<LogRow> PostgresStatements::LoadRoomLog(const RoomId& room, std::uint64_t after,
                                                    std::size_t limit) {
  room_ = room.text();
  revision_ = Clamp(after);
  limit_ = Clamp(limit);
  return Fetch(room_log_);
}

void PostgresStatements::Append(const std::vector<LogRow>& rows) {
  PostgresArray revisions, previous, rooms, ids, states, checksums;
  for (const LogRow& row : rows) {
    revisions.Add(Clamp(row.revision));
    previous.Add(Clamp(row.previous));
    rooms.AddHex(row.room);
    ids.AddHex(row.id);
    states.AddHex(row.state);
    checksums.Add(row.checksum);
  }
  Bind({&revisions, &previous, &rooms, &ids, &states, &checksums});
  append_.execute(true);
}

void PostgresStatements::Put(const std::vector<PlaceRow>& places) {
  PostgresArray rooms, ids, revisions, cells, changed, expires, is_public;
  for (const PlaceRow& place : places) {
    rooms.AddHex(place.key.room.text());
    ids.AddHex(place.key.id.text());
    revisions.Add(Clamp(place.revision));
    cells.Add(place.cell);
    changed.Add(place.changed);
    expires.Add(place.expires);
    is_public.Add(std::int64_t{place.is_public ? 1 : 0});
  }
  Bind({&rooms, &ids, &revisions, &cells, &changed, &expires, &is_public});
  put_.execute(true);
}

std::map<OwnerKey, Usage> PostgresStatements::FindUsage(const std::vector<OwnerKey>& owners) {
  PostgresArray rooms, names;
  for (const OwnerKey& key : owners) {
    rooms.AddHex(key.room);
    names.AddHex(key.owner);
  }
  Bind({&rooms, &names});
  std::map<OwnerKey, Usage> usage;
  find_usage_.execute();
  while (find_usage_.fetch()) usage[{row_room_, row_id_}] = {row_revision_, row_previous_};
  return usage;
}

void PostgresStatements::PutUsage(const std::map<OwnerKey, Usage>& usage) {
  PostgresArray rooms, owners, anchors, bytes;
  for (const auto& [key, owned] : usage) {
    rooms.AddHex(key.room);
    owners.AddHex(key.owner);
    anchors.Add(owned.anchors);
    bytes.Add(owned.bytes);
  }
  Bind({&rooms, &owners, &anchors, &bytes});
  put_usage_.execute(true);
}

void PostgresStatements::Announce(std::uint64_t revision) {
  revision_ = Clamp(revision);
  announce_.execute(true);
}

}  // namespace waymark::content::internal
