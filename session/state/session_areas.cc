// SPDX-License-Identifier: Apache-2.0
// Who asked for the anchors of an area, and what is told of them.
#include <utility>

#include "session/state/session_state.h"

namespace waymark::session {

void SessionState::On(const event::AreaReceived& event, Step& step) {
  RoomMember* const member = FindHeard(event.report.ticket, step.now);
  if (member == nullptr) return;
  Room& room = rooms_.at(member->room);
  if (room.passage) return;  // part of what it would be told is in another release than its pose
  // It asks again for what it has no answer to, so a flood loses nothing but itself.
  if (step.now - member->area_heard < kMinAreaInterval) return;
  member->area_heard = step.now;
  AnchorRelay::Listener& listener =
      room.listeners.try_emplace(member->device, AnchorRelay::Listener(member->device))
          .first->second;
  AnchorRelay::News news = room.relay.Listen(listener, event.report);
  effect::TellArea area{.device = member->device, .leaving = std::move(news.leaving)};
  for (const AnchorId& anchor : news.coming) {
    area.anchors.push_back(AnchorState{run_, room.shared.anchors.at(anchor)});
  }
  area.state = listener.TakeState(room.relay);
  step.effects.push_back(std::move(area));
}

/// To all: gateways and devices choose from it, or hear of it because it is in their area.
void SessionState::PublishAnchor(Room& room, const RoomAnchor& anchor, Step& step) {
  effect::PublishAnchor told{anchor.record.room, {run_, anchor}};
  const AnchorRelay::Change change = room.relay.Put(told.state);
  step.effects.emplace_back(std::move(told));
  for (auto& [device, listener] : room.listeners) {
    if (!listener.Concerns(change)) continue;
    step.effects.push_back(effect::TellArea{.device = device, .anchors = {{run_, anchor}}});
  }
}

void SessionState::PublishAreas(Room& room, Step& step) {
  room.relay.Expect(run_, room.shared.anchors.size(), room.shared.digest);
  for (auto& [device, listener] : room.listeners) {
    auto state = listener.TakeState(room.relay);
    if (!state) continue;
    step.effects.push_back(effect::TellArea{.device = device, .state = std::move(state)});
  }
}

}  // namespace waymark::session
