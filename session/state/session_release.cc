// SPDX-License-Identifier: Apache-2.0
// What becomes of a session when another release goes live under it: nothing that people see moves.
#include <algorithm>

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

void SessionState::On(const event::ReleaseSwapped& event, Step& step) {
  if (event.epoch == map_.epoch) return;
  epoch_before_ = map_.epoch;
  placements_before_ = std::move(placements_);
  map_.epoch = event.epoch;
  placements_ = event.placements;
  ++swaps_;
  effect::ReportSwap report{.epoch = event.epoch};
  for (auto& [id, room] : rooms_) {
    if (!room.is_open) continue;  // its anchors are carried when they have been read
    const auto carry = [&](RoomAnchor& anchor) {
      const Eigen::Vector3d was = anchor.record.map_from_anchor.translation();
      anchor = InLiveMap(anchor);
      const double motion_m = (anchor.record.map_from_anchor.translation() - was).norm();
      report.max_motion_m = std::max(report.max_motion_m, motion_m);
      ++(anchor.is_supported ? report.carried : report.unsupported);
    };
    // First, so that they wait on the device for the map's state, which is told to all and does not
    // say what they hold on to.
    for (auto& [owner, set] : room.own) {
      for (auto& [anchor_id, anchor] : set.anchors) {
        carry(anchor);
        TellOwnChange(room, owner, AnchorState{run_, anchor}, step);
      }
    }
    PublishMap(id, room, step);
    for (auto& [anchor_id, anchor] : room.shared.anchors) {
      carry(anchor);
      PublishAnchor(room, anchor, step);
    }
    PublishState(id, room, step);
  }
  for (auto& [device, member] : members_) {
    member.pose.reset();  // it was in the other frame; the next comes at once
    member.pose_is_due = false;
  }
  step.effects.push_back(report);
}

void SessionState::PublishMap(const RoomId& id, const Room& room, Step& step) {
  MapState state{.room = id, .run = run_, .swap = swaps_, .epoch = map_.epoch};
  const auto add = [&](const SubmapId& submap) {
    if (state.placements.size() >= kMaxPlacements) return;
    const auto placed = placements_->find(submap);
    if (placed != placements_->end()) state.placements.insert(*placed);
  };
  for (const DeviceId& device : room.members) {
    std::ranges::for_each(members_.at(device).found_in, add);
  }
  for (const auto& [anchor_id, anchor] : room.shared.anchors) {
    for (const content::SubmapAttachment& attachment : anchor.record.attachments) {
      add(attachment.submap);
    }
  }
  step.effects.push_back(effect::PublishMapState{std::move(state)});
}

RoomAnchor SessionState::InLiveMap(const content::AnchorRecord& record) const {
  return placements_ ? CarryAnchor(record, map_.epoch, *placements_) : RoomAnchor{record};
}

RoomAnchor SessionState::InLiveMap(const RoomAnchor& anchor) const {
  if (anchor.record.epoch == map_.epoch || !placements_) return anchor;
  return CarryAnchor(anchor.record, map_.epoch, *placements_);
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
