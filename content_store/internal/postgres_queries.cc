// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/postgres_queries.h"

#include <fmt/format.h>

namespace waymark::content::internal {
namespace {

constexpr const char* kColumns = "s.revision, s.previous, s.room, s.id, s.state, s.checksum";

constexpr const char* kPlaces =
    "unnest($1::text[], $2::text[], $3::bigint[], $4::bigint[], $5::bigint[], $6::bigint[], "
    "$7::bigint[]) AS n(room, id, revision, cell, changed, expires, is_public)";

/// All ranges in one statement; each by its index and no farther than the limit. A range has one
/// lower end: where there are two, the index is read from the one that PostgreSQL happens to take.
std::string SelectPlaces(const std::string& key, const std::string& where) {
  return fmt::format(
      "SELECT p.{0}, p.revision FROM unnest($1::bigint[], $2::bigint[], $3::bigint[]) AS r(first, "
      "after, last), LATERAL (SELECT {0}, revision FROM waymark.places WHERE {1} AND ({0}, "
      "revision) > (r.first, r.after) AND {0} <= r.last AND revision <= $4::bigint ORDER BY {0}, "
      "revision LIMIT $5::bigint) AS p ORDER BY p.{0}, p.revision LIMIT $5::bigint",
      key, where);
}

}  // namespace

std::vector<PostgresQuery> PostgresQueries() {
  return {
      {"wm_begin_read", "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY"},
      {"wm_begin_write", "BEGIN ISOLATION LEVEL READ COMMITTED"},
      // 'WMAN'; released after the commit is visible, so the next writer sees it.
      {"wm_lock", "SELECT pg_catalog.pg_advisory_xact_lock(1464680782)"},
      {"wm_commit", "COMMIT"},
      {"wm_rollback", "ROLLBACK"},
      {"wm_latest", "SELECT coalesce(max(revision), 0) FROM waymark.states"},
      // Plain SQL has no other way to fail; PostgresSession knows what this failure says.
      {"wm_require",
       "SELECT 1 / CAST(coalesce(max(revision), 0) = $1::bigint AS integer) FROM waymark.states"},
      {"wm_find",
       "SELECT p.revision, s.previous, p.room, p.id, s.state, s.checksum FROM unnest($1::text[], "
       "$2::text[]) AS k(room, id) JOIN waymark.places p ON p.room = k.room AND p.id = k.id LEFT "
       "JOIN waymark.states s ON s.revision = p.revision"},
      // Two halves, which no plain scan of an index can take: PostgreSQL then collects the places
      // of all rows first and asks the disk for them together, not for one after the other.
      {"wm_load", fmt::format("SELECT {} FROM waymark.states s WHERE s.revision = "
                              "ANY($1::bigint[]) OR s.revision = ANY($2::bigint[])",
                              kColumns)},
      {"wm_by_cell", SelectPlaces("cell", "room = $6::text")},
      {"wm_by_change", SelectPlaces("changed", "room = $6::text")},
      {"wm_public_by_cell", SelectPlaces("cell", "is_public")},
      {"wm_log", fmt::format("SELECT {} FROM waymark.states s WHERE s.revision > $1::bigint ORDER "
                             "BY s.revision LIMIT $2::bigint",
                             kColumns)},
      {"wm_room_log", fmt::format("SELECT {} FROM waymark.states s WHERE s.room = $3::text AND "
                                  "s.revision > $1::bigint ORDER BY s.revision LIMIT $2::bigint",
                                  kColumns)},
      {"wm_append",
       "INSERT INTO waymark.states (revision, previous, room, id, state, checksum) SELECT * FROM "
       "unnest($1::bigint[], $2::bigint[], $3::text[], $4::text[], $5::bytea[], $6::bigint[])"},
      {"wm_add",
       "INSERT INTO waymark.places (room, id, revision, cell, changed, expires, is_public) SELECT "
       "n.room, n.id, n.revision, n.cell, n.changed, n.expires, n.is_public <> 0 FROM " +
           std::string(kPlaces)},
      {"wm_change",
       "UPDATE waymark.places AS p SET revision = n.revision, cell = n.cell, changed = n.changed, "
       "expires = n.expires, is_public = n.is_public <> 0 FROM " +
           std::string(kPlaces) + " WHERE p.room = n.room AND p.id = n.id"},
      {"wm_find_usage",
       "SELECT u.room, u.owner, u.anchors, u.bytes FROM unnest($1::text[], $2::text[]) AS k(room, "
       "owner) JOIN waymark.usage u ON u.room = k.room AND u.owner = k.owner"},
      {"wm_put_usage",
       "INSERT INTO waymark.usage (room, owner, anchors, bytes) SELECT * FROM unnest($1::text[], "
       "$2::text[], $3::bigint[], $4::bigint[]) ON CONFLICT (room, owner) DO UPDATE SET anchors = "
       "excluded.anchors, bytes = excluded.bytes"},
      {"wm_announce", "SELECT pg_catalog.pg_notify('waymark_anchors', $1::bigint::text)"},
  };
}

}  // namespace waymark::content::internal
