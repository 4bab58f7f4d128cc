// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/postgres_statements.h"

#include <stdexcept>
#include <utility>

#include "content_store/internal/postgres_binary.h"
#include "content_store/internal/postgres_queries.h"
#include "content_store/internal/sql_numbers.h"

namespace waymark::content::internal {
namespace {

constexpr auto kNumber = BinaryArray::kNumber;
constexpr auto kText = BinaryArray::kText;

std::vector<LogRow> ToLogRows(const PostgresRows& rows) {
  std::vector<LogRow> log;
  log.reserve(static_cast<std::size_t>(rows.size()));
  for (int i = 0; i < rows.size(); ++i) {
    const bool is_there = !rows.IsNull(i, 4);
    log.push_back({.revision = rows.Revision(i, 0),
                   .previous = is_there ? rows.Revision(i, 1) : 0,
                   .room = rows.Text(i, 2),
                   .id = rows.Text(i, 3),
                   .state = rows.Text(i, 4),
                   .checksum = is_there ? rows.Number(i, 5) : 0});
  }
  return log;
}

std::map<OwnerKey, Usage> ToUsage(const PostgresRows& rows) {
  std::map<OwnerKey, Usage> usage;
  for (int i = 0; i < rows.size(); ++i) {
    usage[{rows.Text(i, 0), rows.Text(i, 1)}] = {rows.Number(i, 2), rows.Number(i, 3)};
  }
  return usage;
}

}  // namespace

PostgresStatements::PostgresStatements(PostgresPipeline& pipeline) : pipeline_(pipeline) {
  for (const PostgresQuery& query : PostgresQueries()) pipeline_.Prepare(query.name, query.text);
  (void)pipeline_.Await();
}

void PostgresStatements::BeginWrite() {
  pipeline_.Send("wm_begin_write");
  pipeline_.Send("wm_lock");
}

void PostgresStatements::CommitRead() {
  pipeline_.Send("wm_commit");
  pipeline_.Flush();
}

void PostgresStatements::CommitWrite() {
  pipeline_.Send("wm_commit");
  (void)pipeline_.Await();
}

void PostgresStatements::Rollback() {
  pipeline_.Send("wm_rollback");
  (void)pipeline_.Await();
}

PostgresRows PostgresStatements::AwaitLast() {
  std::vector<PostgresRows> answers = pipeline_.Await();
  if (answers.empty()) throw std::runtime_error("expected an answer from the database");
  return std::move(answers.back());
}

std::uint64_t PostgresStatements::Latest() {
  pipeline_.Send("wm_latest");
  return AwaitLast().Revision(0, 0);
}

WriteBasis PostgresStatements::LoadBasis(const std::vector<AnchorKey>& keys,
                                         const std::vector<OwnerKey>& owners) {
  pipeline_.Send("wm_latest");
  SendFindLatest(keys);
  SendFindUsage(owners);
  const std::vector<PostgresRows> answers = pipeline_.Await();
  if (answers.size() < 3) throw std::runtime_error("expected three answers from the database");
  const auto last = answers.end();
  return {(last - 3)->Revision(0, 0), ToLogRows(*(last - 2)), ToUsage(*(last - 1))};
}

void PostgresStatements::SendFindLatest(const std::vector<AnchorKey>& keys) {
  BinaryArray rooms(kText), ids(kText);
  for (const AnchorKey& key : keys) {
    rooms.Add(key.room.text());
    ids.Add(key.id.text());
  }
  pipeline_.Send("wm_find", {std::move(rooms).Take(), std::move(ids).Take()});
}

std::vector<LogRow> PostgresStatements::FindLatest(const std::vector<AnchorKey>& keys) {
  SendFindLatest(keys);
  return ToLogRows(AwaitLast());
}

void PostgresStatements::SendFindUsage(const std::vector<OwnerKey>& owners) {
  BinaryArray rooms(kText), names(kText);
  for (const OwnerKey& key : owners) {
    rooms.Add(key.room);
    names.Add(key.owner);
  }
  pipeline_.Send("wm_find_usage", {std::move(rooms).Take(), std::move(names).Take()});
}

std::map<OwnerKey, Usage> PostgresStatements::FindUsage(const std::vector<OwnerKey>& owners) {
  SendFindUsage(owners);
  return ToUsage(AwaitLast());
}

std::vector<LogRow> PostgresStatements::LoadStates(const std::vector<std::uint64_t>& revisions) {
  BinaryArray first(kNumber), second(kNumber);
  for (std::size_t i = 0; i < revisions.size(); ++i) {
    (i < revisions.size() / 2 ? first : second).Add(Clamp(revisions[i]));
  }
  pipeline_.Send("wm_load", {std::move(first).Take(), std::move(second).Take()});
  return ToLogRows(AwaitLast());
}

std::vector<Position> PostgresStatements::FindPlaces(const Scan& scan) {
  BinaryArray firsts(kNumber), afters(kNumber), lasts(kNumber);
  for (const auto& [first, last] : scan.ranges) {
    if (last < scan.after.key) continue;
    const bool has_begun = first <= scan.after.key;
    firsts.Add(has_begun ? scan.after.key : first);
    afters.Add(has_begun ? Clamp(scan.after.revision) : 0);  // revisions begin with 1
    lasts.Add(last);
  }
  std::vector<std::string> parameters{std::move(firsts).Take(), std::move(afters).Take(),
                                      std::move(lasts).Take(), ToBinary(Clamp(scan.newest)),
                                      ToBinary(Clamp(scan.limit))};
  if (scan.room) parameters.push_back(scan.room->text());
  pipeline_.Send(!scan.room                          ? "wm_public_by_cell"
                 : scan.order == ScanOrder::kChanged ? "wm_by_change"
                                                     : "wm_by_cell",
                 parameters);
  const PostgresRows rows = AwaitLast();
  std::vector<Position> positions;
  for (int i = 0; i < rows.size(); ++i)
    positions.push_back({rows.Number(i, 0), rows.Revision(i, 1)});
  return positions;
}

std::vector<LogRow> PostgresStatements::LoadLog(const std::optional<RoomId>& room,
                                                std::uint64_t after, std::size_t limit) {
  std::vector<std::string> parameters{ToBinary(Clamp(after)), ToBinary(Clamp(limit))};
  if (room) parameters.push_back(room->text());
  pipeline_.Send(room ? "wm_room_log" : "wm_log", parameters);
  return ToLogRows(AwaitLast());
}

void PostgresStatements::Require(std::uint64_t latest) {
  pipeline_.Send("wm_require", {ToBinary(Clamp(latest))});
}

void PostgresStatements::Append(const std::vector<LogRow>& rows) {
  BinaryArray revisions(kNumber), previous(kNumber), checksums(kNumber);
  BinaryArray rooms(kText), ids(kText), states(BinaryArray::kBytes);
  for (const LogRow& row : rows) {
    revisions.Add(Clamp(row.revision));
    previous.Add(Clamp(row.previous));
    rooms.Add(row.room);
    ids.Add(row.id);
    states.Add(row.state);
    checksums.Add(row.checksum);
  }
  pipeline_.Send("wm_append",
                 {std::move(revisions).Take(), std::move(previous).Take(), std::move(rooms).Take(),
                  std::move(ids).Take(), std::move(states).Take(), std::move(checksums).Take()});
}

void PostgresStatements::SendPlaces(const char* query, const std::vector<PlaceRow>& places) {
  BinaryArray rooms(kText), ids(kText), revisions(kNumber), cells(kNumber), changed(kNumber);
  BinaryArray expires(kNumber), is_public(kNumber);
  for (const PlaceRow& place : places) {
    rooms.Add(place.key.room.text());
    ids.Add(place.key.id.text());
    revisions.Add(Clamp(place.revision));
    cells.Add(place.cell);
    changed.Add(place.changed);
    expires.Add(place.expires);
    is_public.Add(std::int64_t{place.is_public ? 1 : 0});
  }
  pipeline_.Send(query,
                 {std::move(rooms).Take(), std::move(ids).Take(), std::move(revisions).Take(),
                  std::move(cells).Take(), std::move(changed).Take(), std::move(expires).Take(),
                  std::move(is_public).Take()});
}

void PostgresStatements::PutUsage(const std::map<OwnerKey, Usage>& usage) {
  BinaryArray rooms(kText), owners(kText), anchors(kNumber), bytes(kNumber);
  for (const auto& [key, owned] : usage) {
    rooms.Add(key.room);
    owners.Add(key.owner);
    anchors.Add(owned.anchors);
    bytes.Add(owned.bytes);
  }
  pipeline_.Send("wm_put_usage", {std::move(rooms).Take(), std::move(owners).Take(),
                                  std::move(anchors).Take(), std::move(bytes).Take()});
}

void PostgresStatements::Announce(std::uint64_t revision) {
  pipeline_.Send("wm_announce", {ToBinary(Clamp(revision))});
}

}  // namespace waymark::content::internal
