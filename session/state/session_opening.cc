// SPDX-License-Identifier: Apache-2.0
// A room that nobody was in: its anchors are read, and who comes meanwhile waits.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "session/state/session_state.h"

namespace waymark::session {

void SessionState::OpenFor(const event::HelloReceived& event, Step& step) {
  const Hello& hello = event.hello;
  if (!rooms_.contains(hello.room)) {
    if (options_.opening == RoomOpening::kModerators && !MayModerate(event.permit.role)) {
      return Refuse(
          hello, JoinVerdict::kRefused,
          fmt::format("room {}: is opened by a moderator, who is not here yet", hello.room.text()),
          step);
    }
    if (rooms_.size() >= options_.max_rooms) {
      return Refuse(hello, JoinVerdict::kRefused,
                    fmt::format("the server holds its {} rooms already", options_.max_rooms), step);
    }
    step.effects.push_back(effect::LoadRoom{hello.room});
  }
  Room& opening = rooms_[hello.room];
  opening.last_used = step.now;
  const auto repeated = std::find_if(
      opening.waiting.begin(), opening.waiting.end(),
      [&](const event::HelloReceived& waiting) { return waiting.hello.device == hello.device; });
  if (repeated != opening.waiting.end()) {
    *repeated = event;
  } else if (opening.waiting.size() < options_.max_members) {
    opening.waiting.push_back(event);
  }
}

void SessionState::On(const event::RoomPartLoaded& event, Step& step) {
  const auto found = rooms_.find(event.room);
  if (found == rooms_.end() || found->second.is_open) return;
  ShowLoaded(event.room, found->second, event.anchors, step);
  found->second.has_parts = true;
}

void SessionState::ShowLoaded(const RoomId& id, Room& room, const std::vector<RoomAnchor>& anchors,
                              Step& step) {
  if (!room.has_parts) step.effects.push_back(effect::OpenRoom{id});
  for (const RoomAnchor& loaded : anchors) Show(room, InLiveMap(loaded), step);
}

/// Another release may have gone live between two parts.
void SessionState::ShowMoved(Room& room, Step& step) {
  std::vector<RoomAnchor> moved;
  const auto look_at = [&](const AnchorSet& set) {
    for (const auto& [id, anchor] : set.anchors) {
      if (anchor.record.epoch != map_.epoch) moved.push_back(InLiveMap(anchor));
    }
  };
  look_at(room.shared);
  for (const auto& [owner, set] : room.own) look_at(set);
  for (const RoomAnchor& anchor : moved) Show(room, anchor, step);
}

void SessionState::On(const event::RoomLoaded& event, Step& step) {
  const auto found = rooms_.find(event.room);
  if (found == rooms_.end() || found->second.is_open) return;
  Room& room = found->second;
  const std::vector<event::HelloReceived> waiting = std::move(room.waiting);
  if (!event.revision.ok()) {
    rooms_.erase(found);
    for (const event::HelloReceived& hello : waiting) {
      Refuse(hello.hello, JoinVerdict::kUnavailable, ToString(event.revision.error()), step);
    }
    return;
  }
  room.is_open = true;
  room.capacity = static_cast<std::uint32_t>(options_.max_members);
  room.waiting.clear();
  room.shared.revision = room.followed = *event.revision;
  ShowLoaded(event.room, room, event.anchors, step);
  if (room.has_parts) ShowMoved(room, step);
  for (const content::AnchorChange& change : std::exchange(room.early, {})) {
    Follow(room, change, step);
  }
  PublishState(event.room, room, step);
  for (const event::HelloReceived& hello : waiting) Admit(hello, step);
}

}  // namespace waymark::session
