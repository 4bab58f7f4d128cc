// SPDX-License-Identifier: Apache-2.0
// What the store's change feed tells: writes of other servers, expiry, and once more our own.
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
    } else if (Follow(room, change, step)) {
      changed.insert(change.room);
    }
  }
  for (const RoomId& id : changed) PublishState(id, rooms_.at(id), step);
}

// Whether that was news.
bool SessionState::Follow(Room& room, const content::AnchorChange& change, Step& step) {
  if (change.revision <= room.followed) return false;
  room.followed = change.revision;
  const auto known = room.anchors.find(change.id);
  const bool is_known =
      room.removed.contains(change.id) ||
      (known != room.anchors.end() && known->second.record.revision >= change.revision);
  if (!change.record) {
    room.removed.erase(change.id);
    Hide(room, change.room, change.id, change.revision, step);
  } else if (!is_known) {
    Show(room, InLiveMap(*change.record), step);
  }
  return !is_known;
}

/// An anchor that became its owner's alone goes from the others' eyes.
void SessionState::Show(Room& room, const RoomAnchor& anchor, Step& step) {
  const content::AnchorRecord& record = anchor.record;
  if (!IsForTheRoom(record)) return Hide(room, record.room, record.id, record.revision, step);
  room.Put(anchor);
  step.effects.push_back(effect::PublishAnchor{record.room, AnchorState{run_, anchor}});
}

void SessionState::Hide(Room& room, const RoomId& id, const AnchorId& anchor,
                        std::uint64_t revision, Step& step) {
  const bool is_shown = room.anchors.contains(anchor);
  room.Remove(anchor, revision);
  if (is_shown) step.effects.push_back(effect::WithdrawAnchor{id, anchor});
}

}  // namespace waymark::session
