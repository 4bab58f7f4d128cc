// SPDX-License-Identifier: Apache-2.0
// What the store's change feed tells: writes of other servers, expiry, and once more our own. Who
// is shown it.
#include "session/state/session_state.h"

namespace waymark::session {

void SessionState::On(const event::StoreChanged& event, Step& step) {
  std::set<RoomId> changed;
  for (const content::AnchorChange& change : event.changes) {
    const auto found = rooms_.find(change.room);
    if (found == rooms_.end()) continue;
    Room& room = found->second;
    if (!room.is_open) {
      room.early.push_back(change);  // what is being read may or may not have it
      continue;
    }
    Follow(room, change, step);
    changed.insert(change.room);
  }
  for (const RoomId& id : changed) PublishState(id, rooms_.at(id), step);
}

void SessionState::Follow(Room& room, const content::AnchorChange& change, Step& step) {
  if (change.revision <= room.followed) return;
  room.followed = change.revision;
  const RoomAnchor* const known = room.Find(change.id);
  const bool is_known = room.removed.contains(change.id) ||
                        (known != nullptr && known->record.revision >= change.revision);
  if (!change.record) {
    room.removed.erase(change.id);
    Hide(room, change.room, change.id, change.revision, step);
  } else if (!is_known) {
    Show(room, InLiveMap(*change.record), step);
  }
}

/// An anchor that became its owner's alone goes from the others' eyes, and the other way round.
void SessionState::Show(Room& room, RoomAnchor anchor, Step& step) {
  const content::AnchorRecord& record = anchor.record;
  Settle(room, record.id);
  if (IsStaging()) {
    if (!room.passage) room.passage.emplace();
    room.passage->again.insert(record.id);
  }
  if (!IsForTheRoom(record)) {
    HideShared(room, record.room, record.id, record.revision, step);
    return ShowOwn(room, std::move(anchor), step);
  }
  HideOwn(room, record.id, record.revision, step);
  PublishAnchor(room, anchor, step);
  room.shared.Put(std::move(anchor));
}

void SessionState::Hide(Room& room, const RoomId& id, const AnchorId& anchor,
                        std::uint64_t revision, Step& step) {
  HideShared(room, id, anchor, revision, step);
  HideOwn(room, anchor, revision, step);
}

void SessionState::HideShared(Room& room, const RoomId& id, const AnchorId& anchor,
                              std::uint64_t revision, Step& step) {
  if (!room.shared.Remove(anchor, revision)) return;
  step.effects.push_back(effect::WithdrawAnchor{id, anchor});
  const AnchorRelay::Change change = room.relay.Remove(anchor);
  for (auto& [device, listener] : room.listeners) {
    if (!listener.Concerns(change)) continue;
    step.effects.push_back(effect::TellArea{.device = device, .over = {anchor}});
  }
}

// ---- what an owner alone may see --------------------------------------------------------------

void SessionState::ShowOwn(Room& room, RoomAnchor anchor, Step& step) {
  const std::string owner = anchor.record.owner;
  const AnchorState told{run_, anchor};
  room.own[owner].Put(std::move(anchor));
  TellOwnChange(room, owner, told, step);
}

void SessionState::HideOwn(Room& room, const AnchorId& anchor, std::uint64_t revision, Step& step) {
  for (auto set = room.own.begin(); set != room.own.end(); ++set) {
    if (!set->second.Remove(anchor, revision)) continue;
    TellOwnChange(room, set->first, anchor, step);
    if (set->second.anchors.empty()) room.own.erase(set);
    return;
  }
}

OwnerState SessionState::StateOf(const Room& room, const std::string& owner) const {
  const auto own = room.own.find(owner);
  if (own == room.own.end()) return {.owner = owner, .run = run_};
  return {.owner = owner,
          .run = run_,
          .anchor_count = static_cast<std::uint32_t>(own->second.anchors.size()),
          .anchor_digest = own->second.digest};
}

void SessionState::TellOwnChange(const Room& room, const std::string& owner,
                                 const std::variant<AnchorState, AnchorId>& change, Step& step) {
  for (const DeviceId& device : room.members) {
    if (members_.at(device).owner() != owner) continue;
    step.effects.push_back(effect::SendOwnChange{device, change, StateOf(room, owner)});
  }
}

void SessionState::TellOwn(RoomMember& member, Step& step) {
  const Room& room = rooms_.at(member.room);
  member.own_told = step.now;
  member.is_own_due = false;
  effect::SendOwn all{member.device, {}, StateOf(room, member.owner())};
  if (const auto own = room.own.find(member.owner()); own != room.own.end()) {
    for (const auto& [id, anchor] : own->second.anchors) {
      all.anchors.push_back(AnchorState{run_, anchor});
    }
  }
  step.effects.push_back(std::move(all));
}

// Whoever says Hello again may have found another way to hear, but a flood of them costs no more.
void SessionState::TellOwnDue(Step& step) {
  constexpr std::chrono::seconds kInterval{1};
  for (auto& [device, member] : members_) {
    if (!member.is_own_due || step.now - member.own_told < kInterval) continue;
    if (!rooms_.at(member.room).passage) TellOwn(member, step);
  }
}

}  // namespace waymark::session
