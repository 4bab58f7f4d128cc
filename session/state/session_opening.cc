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
  Wait(rooms_[hello.room], event, step);
}

void SessionState::Wait(Room& room, const event::HelloReceived& event, Step& step) {
  room.last_used = step.now;
  const auto repeated = std::find_if(room.waiting.begin(), room.waiting.end(),
                                     [&](const event::HelloReceived& waiting) {
                                       return waiting.hello.device == event.hello.device;
                                     });
  if (repeated != room.waiting.end()) {
    *repeated = event;
  } else if (room.waiting.size() < options_.max_members) {
    room.waiting.push_back(event);
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

void SessionState::On(const event::RoomLoaded& event, Step& step) {
  const auto found = rooms_.find(event.room);
  if (found == rooms_.end() || found->second.is_open) return;
  Room& room = found->second;
  const std::vector<event::HelloReceived> waiting = std::exchange(room.waiting, {});
  if (!event.revision.ok()) {
    rooms_.erase(found);
    for (const event::HelloReceived& hello : waiting) {
      Refuse(hello.hello, JoinVerdict::kUnavailable, ToString(event.revision.error()), step);
    }
    return;
  }
  room.is_open = true;
  room.shared.revision = room.followed = *event.revision;
  ShowLoaded(event.room, room, event.anchors, step);
  for (const content::AnchorChange& change : std::exchange(room.early, {})) {
    Follow(room, change, step);
  }
  PublishState(event.room, room, step);
  for (const event::HelloReceived& hello : waiting) {
    room.passage ? Wait(room, hello, step) : Admit(hello, step);
  }
}

}  // namespace waymark::session
