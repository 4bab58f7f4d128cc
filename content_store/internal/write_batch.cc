// SPDX-License-Identifier: Apache-2.0
#include "content_store/internal/write_batch.h"

#include <utility>

#include "content_store/anchor_rules.h"

namespace waymark::content::internal {
namespace {

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

Error WriteBatch::NotAsForeseen() const {
  return MakeError(ErrorCode::kConflict, "{}: expected revision {} and new ids", tables_.name(),
                   foreseen_->latest);
}

Result<std::vector<Result<WriteOutcome>>> WriteBatch::Run(
    const std::vector<const WriteRequest*>& requests) {
  if (foreseen_ && !tables_.Require(foreseen_->latest)) return NotAsForeseen();
  LoadBasis(requests);
  LoadOwners(requests);
  std::vector<Result<WriteOutcome>> outcomes;
  outcomes.reserve(requests.size());
  for (std::size_t i = 0; i < requests.size(); ++i) {
    outcomes.push_back(Apply(*requests[i], *asked_[i]));
    if (foreseen_ && !outcomes.back()) return NotAsForeseen();
  }
  if (has_written()) Store();
  return outcomes;
}

/// The anchors that are asked for, and the owners that the requests name.
void WriteBatch::LoadBasis(const std::vector<const WriteRequest*>& requests) {
  std::vector<AnchorKey> keys;
  for (const WriteRequest* request : requests) {
    const AnchorRecord& record = request->record;
    const auto [entry, is_new] = slots_.try_emplace({record.room, record.id});
    asked_.push_back(&entry->second);
    // What is no text is in no store, and some databases would not even be asked about it.
    if (is_new && IsText(record.room.text()) && IsText(record.id.text())) {
      keys.push_back(entry->first);
    }
    if (request->kind != WriteKind::kCreate) continue;
    known_owners_.insert({record.room.text(), record.owner});
  }
  WriteBasis basis = foreseen_
                         ? *foreseen_
                         : tables_.LoadBasis(keys, {known_owners_.begin(), known_owners_.end()});
  basis_revision_ = revision_ = basis.latest;
  usage_ = std::move(basis.usage);
  for (const LogRow& row : basis.present) {
    auto state = VerifyRow(tables_.name(), row);
    Slot& slot = slots_.at({RoomId(row.room), AnchorId(row.id)});
    if (state) {
      slot.present = std::optional(*std::move(state));
    } else {
      slot.present = state.error();
    }
  }
}

/// The owners of what is there already and may change.
void WriteBatch::LoadOwners(const std::vector<const WriteRequest*>& requests) {
  std::vector<OwnerKey> owners;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto& present = asked_[i]->present;
    if (requests[i]->kind == WriteKind::kCreate) continue;
    if (!present || !*present || (*present)->is_deleted) continue;
    const OwnerKey owner{requests[i]->record.room.text(), (*present)->record.owner};
    if (known_owners_.insert(owner).second) owners.push_back(owner);
  }
  if (!owners.empty()) usage_.merge(tables_.FindUsage(owners));
}

Result<WriteOutcome> WriteBatch::Apply(const WriteRequest& request, Slot& slot) {
  if (!slot.present) return slot.present.error();
  if (request.kind == WriteKind::kCreate) return Create(request, slot);
  std::optional<AnchorState>& present = *slot.present;
  const bool is_expected =
      present && !present->is_deleted && present->record.revision == request.expected_revision;
  if (!is_expected) return {ConflictWith(present)};
  WAYMARK_TRY(Admit(request, present->record.owner));
  if (request.kind != WriteKind::kDelete) return Change(request, slot);
  WAYMARK_TRY(
      Account(present->record.room.text(), present->record.owner, -1, -PayloadBytes(*present)));
  AnchorRecord last = present->record;
  AnchorState deletion{.record = {.id = last.id, .room = last.room}, .creation = {}};
  deletion.is_deleted = true;
  last.revision = Append(slot, std::move(deletion)).revision;
  return {std::move(last)};
}

Result<WriteOutcome> WriteBatch::Create(const WriteRequest& request, Slot& slot) {
  std::string creation = ContentFingerprint(request.record);
  const std::optional<AnchorState>& present = *slot.present;
  if (present) {
    const bool is_retry = !present->is_deleted && present->creation == creation;
    if (is_retry) return {present->record};
    return {ConflictWith(present)};
  }
  WAYMARK_TRY(Admit(request, request.record.owner));
  AnchorState state{.record = request.record, .creation = std::move(creation)};
  WAYMARK_TRY(Account(state.record.room.text(), state.record.owner, 1, PayloadBytes(state)));
  return {Append(slot, std::move(state))};
}

Result<WriteOutcome> WriteBatch::Change(const WriteRequest& request, Slot& slot) {
  const AnchorState& present = **slot.present;
  AnchorState next{.record = Changed(request, present.record), .creation = present.creation};
  WAYMARK_TRY(Account(present.record.room.text(), present.record.owner, 0,
                      PayloadBytes(next) - PayloadBytes(present)));
  return {Append(slot, std::move(next))};
}

Result<void> WriteBatch::Admit(const WriteRequest& request, const std::string& owner) {
  if (!request.is_limited) return {};
  WAYMARK_TRY(rates_.Admit(owner, now_));
  admitted_.push_back(owner);
  return {};
}

void WriteBatch::ReturnRates() {
  for (const std::string& owner : admitted_) rates_.Return(owner);
  admitted_.clear();
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

AnchorRecord WriteBatch::Append(Slot& slot, AnchorState next) {
  std::optional<AnchorState>& present = *slot.present;
  slot.is_new = slot.is_new || !present;
  slot.is_changed = true;
  const std::uint64_t previous = present ? present->record.revision : 0;
  next.record.revision = ++revision_;
  rows_.push_back(ToLogRow(next, previous));
  present = std::move(next);
  return present->record;
}

void WriteBatch::Store() {
  tables_.AppendLog(rows_);
  std::vector<PlaceRow> added, changed;
  for (const auto& [key, slot] : slots_) {  // in the order of the index
    if (slot.is_changed) (slot.is_new ? added : changed).push_back(ToPlaceRow(**slot.present));
  }
  if (!added.empty()) tables_.AddPlaces(added);
  if (!changed.empty()) tables_.ChangePlaces(changed);
  std::map<OwnerKey, Usage> usage;
  for (const OwnerKey& owner : changed_usage_) usage.emplace(owner, usage_.at(owner));
  if (!usage.empty()) tables_.PutUsage(usage);
  tables_.Announce(revision_);
}

}  // namespace waymark::content::internal
