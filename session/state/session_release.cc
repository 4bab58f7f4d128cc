// SPDX-License-Identifier: Apache-2.0
// What becomes of a session when another release goes live under it: nothing that people see moves.
#include <algorithm>
#include <utility>

#include "session/state/carrying.h"
#include "session/state/session_state.h"

namespace waymark::session {

void SessionState::On(const event::Localised& event, Step&) {
  const auto member = members_.find(event.device);
  if (member == members_.end()) return;
  std::deque<SubmapId>& found_in = member->second.found_in;
  std::erase(found_in, event.submap);
  found_in.push_front(event.submap);
  if (found_in.size() > kMaxAttachments) found_in.pop_back();
}

// A phone carries what it holds by the submaps that a MapState names. Where that has room for all
// of them the release goes live at once, and anchors are told in it afterwards. Else they are told
// first, wait on the phones, and are shown from when it goes live.
void SessionState::On(const event::ReleaseSwapped& event, Step& step) {
  if (event.epoch == (carrying_ ? carrying_->epoch : map_.epoch)) return;
  const bool is_live = event.epoch == map_.epoch;  // one that was on its way is given up
  carrying_.emplace(Carrying{event.epoch, event.placements, is_live});
  if (!is_live) carrying_->report = {.epoch = event.epoch};
  for (auto& [id, room] : rooms_) {
    if (room.passage) {
      room.passage->BeginAnew();
    } else if (room.HasAnchors()) {
      room.passage.emplace();
    }
  }
  const bool fits = !placements_ || event.placements->size() <= kMaxPlacements;
  if (!is_live && fits) GoLive(step);
  CarryOn(step);
}

void SessionState::GoLive(Step& step) {
  epoch_before_ = std::exchange(map_.epoch, carrying_->epoch);
  placements_before_ = std::exchange(placements_, carrying_->placements);
  carrying_->is_live = true;
  ++swaps_;
  step.effects.push_back(effect::GoLive{map_.epoch});
  for (auto& [id, room] : rooms_) {
    if (room.passage) room.passage->unsupported.clear();
    if (!room.is_open) continue;
    PublishMap(id, room, step);
    PublishState(id, room, step);
  }
  for (auto& [device, member] : members_) {
    member.pose.reset();  // it was in the other frame; the next comes at once
    member.pose_is_due = false;
  }
}

void SessionState::PublishMap(const RoomId& id, const Room& room, Step& step) {
  MapState state{.room = id, .run = run_, .swap = swaps_, .epoch = map_.epoch};
  const auto add = [&](const SubmapId& submap) {
    if (state.placements.size() >= kMaxPlacements) return;
    const auto placed = placements_->find(submap);
    if (placed != placements_->end()) state.placements.insert(*placed);
  };
  if (placements_->size() <= kMaxPlacements) {
    state.placements = *placements_;
  } else {
    for (const DeviceId& device : room.members) {
      std::ranges::for_each(members_.at(device).found_in, add);
    }
    if (room.passage) std::ranges::for_each(room.passage->submaps, add);
  }
  step.effects.push_back(effect::PublishMapState{std::move(state)});
}

RoomAnchor SessionState::InLiveMap(const content::AnchorRecord& record) const {
  return placements_ ? CarryAnchor(record, map_.epoch, *placements_) : RoomAnchor{record};
}

RoomAnchor SessionState::InLiveMap(RoomAnchor anchor) const {
  if (anchor.record.epoch != map_.epoch && placements_) Carry(anchor, map_.epoch, *placements_);
  return anchor;
}

// Said before its device heard of the swap.
AnchorCommand SessionState::InLiveMap(const AnchorCommand& command) const {
  const bool is_of_before = command.epoch == epoch_before_ && placements_ && placements_before_;
  if (command.epoch == map_.epoch || !is_of_before) return command;
  const auto carried =
      CarryBetween(command.map_from_anchor, command.seen_in, *placements_before_, *placements_);
  if (!carried) return command;
  AnchorCommand translated = command;
  translated.map_from_anchor = *carried;
  translated.epoch = map_.epoch;
  return translated;
}

}  // namespace waymark::session
