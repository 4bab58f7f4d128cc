// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/write_batch.h"

#include <utility>

#include "content_store/anchor_rules.h"

namespace waymark::content::internal {
namespace {

AnchorKey KeyOf(const WriteRequest& request) { return {request.record.room, request.record.id}; }

WriteConflict ConflictWith(const std::optional<AnchorState>& state) {
  if (!state || state->is_deleted) return {};
  return {state->record};
}

std::int64_t PayloadBytes(const AnchorState& state) { return std::ssize(state.record.payload); }

/// What an update or a move makes of a record.
AnchorRecord Changed(const WriteRequest& request, const AnchorRecord& present) {
  AnchorRecord next = request.kind == WriteKind::kMove ? present : request.record;
  if (request.kind == WriteKind::kMove) {
    next.map_from_anchor = request.record.map_from_anchor;
    next.epoch = request.record.epoch;
    next.attachments = request.record.attachments;
    next.place = request.record.place;
    next.changed_utc_ms = request.record.changed_utc_ms;
    next.unsupported_since_epoch.reset();
  }
  next.owner = present.owner;
  next.created_utc_ms = present.created_utc_ms;
  return next;
}

}  // namespace

std::vector<Result<WriteOutcome>> WriteBatch::Run(
    const std::vector<const WriteRequest*>& requests) {
  revision_ = tables_.LatestRevision();
  LoadPresent(requests);
  LoadUsage(requests);
  std::vector<Result<WriteOutcome>> outcomes;
  outcomes.reserve(requests.size());
  for (const WriteRequest* request : requests) outcomes.push_back(Apply(*request));
  if (has_written()) Store();
  return outcomes;
}

void WriteBatch::LoadPresent(const std::vector<const WriteRequest*>& requests) {
  std::vector<AnchorKey> keys;
  for (const WriteRequest* request : requests) {
    const auto [entry, is_new] = present_.try_emplace(KeyOf(*request), std::nullopt);
    // What is no text is in no store, and some databases would not even be asked about it.
    if (is_new && IsText(entry->first.room.text()) && IsText(entry->first.id.text())) {
      keys.push_back(entry->first);
    }
  }
  for (const LogRow& row : tables_.FindLatest(keys)) {
    auto state = VerifyRow(tables_.name(), row);
    Present& present = present_.at({RoomId(row.room), AnchorId(row.id)});
    present = state ? Present(std::optional(*std::move(state))) : Present(state.error());
  }
}

void WriteBatch::LoadUsage(const std::vector<const WriteRequest*>& requests) {
  std::set<OwnerKey> owners;
  for (const WriteRequest* request : requests) {
    const Present& present = present_.at(KeyOf(*request));
    if (!present) continue;
    const bool is_live = *present && !(*present)->is_deleted;
    if (request->kind != WriteKind::kCreate && !is_live) continue;
    const std::string& owner = is_live ? (*present)->record.owner : request->record.owner;
    owners.insert({request->record.room.text(), owner});
    owners.insert({request->record.room.text(), request->record.owner});
  }
  usage_ = tables_.FindUsage({owners.begin(), owners.end()});
}

Result<WriteOutcome> WriteBatch::Apply(const WriteRequest& request) {
  Present& present = present_.at(KeyOf(request));
  if (!present) return present.error();
  if (request.kind == WriteKind::kCreate) return Create(request, *present);
  const bool is_expected = *present && !(*present)->is_deleted &&
                           (*present)->record.revision == request.expected_revision;
  if (!is_expected) return {ConflictWith(*present)};
  if (request.is_limited) WAYMARK_TRY(rates_.Admit((*present)->record.owner, now_));
  AnchorState& state = **present;
  if (request.kind != WriteKind::kDelete) return Change(request, state);
  WAYMARK_TRY(Account(state.record.room.text(), state.record.owner, -1, -PayloadBytes(state)));
  AnchorRecord last = state.record;
  AnchorState deletion{.record = {.id = last.id, .room = last.room}, .creation = {}};
  deletion.is_deleted = true;
  last.revision = Append(*present, std::move(deletion)).revision;
  return {std::move(last)};
}

Result<WriteOutcome> WriteBatch::Create(const WriteRequest& request,
                                        std::optional<AnchorState>& present) {
  std::string creation = ContentFingerprint(request.record);
  if (present) {
    const bool is_retry = !present->is_deleted && present->creation == creation;
    if (is_retry) return {present->record};
    return {ConflictWith(present)};
  }
  if (request.is_limited) WAYMARK_TRY(rates_.Admit(request.record.owner, now_));
  AnchorState state{.record = request.record, .creation = std::move(creation)};
  WAYMARK_TRY(Account(state.record.room.text(), state.record.owner, 1, PayloadBytes(state)));
  return {Append(present, std::move(state))};
}

Result<WriteOutcome> WriteBatch::Change(const WriteRequest& request, AnchorState& present) {
  AnchorState next{.record = Changed(request, present.record), .creation = present.creation};
  WAYMARK_TRY(Account(present.record.room.text(), present.record.owner, 0,
                      PayloadBytes(next) - PayloadBytes(present)));
  return {Append(*present_.at(KeyOf(request)), std::move(next))};
}

/// Growth is refused beyond the limits; what shrinks is always welcome.
Result<void> WriteBatch::Account(const std::string& room, const std::string& owner,
                                 std::int64_t anchors, std::int64_t bytes) {
  Usage next = usage_[{room, owner}];
  next.anchors += anchors;
  next.bytes += bytes;
  if (anchors > 0 && std::cmp_greater(next.anchors, limits_.max_anchors_per_owner)) {
    return MakeError(ErrorCode::kInvalidArgument, "room {}, owner {}: holds its {} anchors already",
                     room, owner, limits_.max_anchors_per_owner);
  }
  if (bytes > 0 && std::cmp_greater(next.bytes, limits_.max_payload_bytes_per_owner)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "room {}, owner {}: expected at most {} bytes of payload in all, found {}",
                     room, owner, limits_.max_payload_bytes_per_owner, next.bytes);
  }
  if (anchors == 0 && bytes == 0) return {};
  usage_[{room, owner}] = next;
  changed_usage_.insert({room, owner});
  return {};
}

AnchorRecord WriteBatch::Append(std::optional<AnchorState>& present, AnchorState next) {
  const std::uint64_t previous = present ? present->record.revision : 0;
  next.record.revision = ++revision_;
  rows_.push_back(ToLogRow(next, previous));
  changed_.insert({next.record.room, next.record.id});
  present = std::move(next);
  return present->record;
}

void WriteBatch::Store() {
  tables_.AppendLog(rows_);
  std::vector<PlaceRow> places;
  for (const AnchorKey& key : changed_) places.push_back(ToPlaceRow(**present_.at(key)));
  tables_.PutPlaces(places);
  std::map<OwnerKey, Usage> usage;
  for (const OwnerKey& owner : changed_usage_) usage.emplace(owner, usage_.at(owner));
  if (!usage.empty()) tables_.PutUsage(usage);
  tables_.Announce(revision_);
}

}  // namespace waymark::content::internal
