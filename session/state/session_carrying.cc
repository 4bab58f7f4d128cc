// SPDX-License-Identifier: Apache-2.0
// Anchors on their way to another release: some at each tick, so that nobody waits for a large
// room.
#include <algorithm>
#include <iterator>
#include <utility>

#include "session/state/carrying.h"
#include "session/state/session_state.h"

namespace waymark::session {
namespace {

// What one event may cost: looking at an anchor 1, telling it as much as looking at some.
constexpr int kBudget = 5000;
constexpr int kPriceOfTelling = kBudget / static_cast<int>(kCarriedAtOnce);

}  // namespace

void SessionState::CarryOn(Step& step) {
  if (!carrying_) return;
  int budget = kBudget;
  while (budget > 0) {
    Room* const room = FindRoomToCarry();
    if (room == nullptr) return Arrive(step);
    CarrySome(*room, budget, step);
    if (room->passage->IsThrough() && carrying_->is_live) LetIn(*room, step);
  }
}

// Small ones first: they need not wait for a large one.
Room* SessionState::FindRoomToCarry() {
  Room* next = nullptr;
  for (auto& [id, room] : rooms_) {
    if (!room.passage || room.passage->IsThrough()) continue;
    if (next == nullptr || room.shared.anchors.size() < next->shared.anchors.size()) next = &room;
  }
  return next;
}

void SessionState::CarrySome(Room& room, int& budget, Step& step) {
  Passage& passage = *room.passage;
  while (!passage.own_are_through && budget > 0) {
    const auto own = room.own.lower_bound(passage.owner);
    if (own == room.own.end() || own->first != passage.owner) passage.last.reset();
    passage.own_are_through = own == room.own.end();
    if (passage.own_are_through) break;
    passage.owner = own->first;
    if (CarrySome(own->second, room, budget, step)) passage.owner.push_back('\0');  // the next
  }
  if (passage.own_are_through && !passage.is_at_end) {
    passage.is_at_end = CarrySome(room.shared, room, budget, step);
  }
  while (passage.is_at_end && !passage.again.empty() && budget > 0) {
    const AnchorId id = passage.again.extract(passage.again.begin()).value();
    RoomAnchor* const anchor = room.Find(id);
    --budget;
    if (anchor == nullptr) continue;  // deleted meanwhile
    CarryAcross(*anchor, passage);
    TellCarried(room, *anchor, step);
    budget -= kPriceOfTelling;
  }
}

/// Whether the end of the set is reached.
bool SessionState::CarrySome(AnchorSet& set, Room& room, int& budget, Step& step) {
  std::optional<AnchorId>& last = room.passage->last;
  auto next = last ? set.anchors.upper_bound(*last) : set.anchors.begin();
  for (; next != set.anchors.end() && budget > 0; ++next) {
    --budget;
    RoomAnchor& anchor = next->second;
    if (anchor.record.epoch == carrying_->epoch) continue;
    CarryAcross(anchor, *room.passage);
    TellCarried(room, anchor, step);
    budget -= kPriceOfTelling;
  }
  if (next != set.anchors.begin()) last = std::prev(next)->first;
  return next == set.anchors.end();
}

void SessionState::CarryAcross(RoomAnchor& anchor, Passage& passage) {
  if (anchor.record.epoch == carrying_->epoch) return;
  if (IsStaging()) {
    SetInLiveMap(anchor, passage);  // it may have been on its way to another one before
    passage.unsupported.erase(anchor.record.id);
    if (!anchor.is_supported) {
      passage.unsupported.emplace(anchor.record.id, anchor.record.map_from_anchor);
    }
  }
  const Eigen::Vector3d was = anchor.record.map_from_anchor.translation();
  if (carrying_->is_live) {
    SetInLiveMap(anchor, passage);
  } else {
    Carry(anchor, carrying_->epoch, *carrying_->placements);
  }
  auto& report = carrying_->report;
  if (!report) return;
  ++(anchor.is_supported ? report->carried : report->unsupported);
  report->max_motion_m =
      std::max(report->max_motion_m, (anchor.record.map_from_anchor.translation() - was).norm());
}

void SessionState::TellCarried(Room& room, const RoomAnchor& anchor, Step& step) {
  const content::AnchorRecord& record = anchor.record;
  if (!IsForTheRoom(record)) {
    return TellOwnChange(room, record.owner, AnchorState{run_, anchor}, step);
  }
  PublishAnchor(room, anchor, step);
  std::set<SubmapId>& submaps = room.passage->submaps;
  for (const content::SubmapAttachment& attachment : record.attachments) {
    if (submaps.size() < kMaxPlacements) submaps.insert(attachment.submap);
  }
}

/// All are told.
void SessionState::Arrive(Step& step) {
  if (!carrying_->is_live) GoLive(step);
  if (carrying_->report) step.effects.push_back(*carrying_->report);
  carrying_.reset();
  for (auto& [id, room] : rooms_) {
    if (room.passage) LetIn(room, step);
  }
}

// Who came meanwhile would have been told anchors of two releases, and have none to carry.
void SessionState::LetIn(Room& room, Step& step) {
  room.passage.reset();
  if (!room.is_open) return;
  for (const event::HelloReceived& hello : std::exchange(room.waiting, {})) On(hello, step);
}

void SessionState::SetInLiveMap(RoomAnchor& anchor, const Passage& passage) const {
  if (anchor.record.epoch == map_.epoch || !placements_) return;
  Carry(anchor, map_.epoch, *placements_);
  const auto stood = passage.unsupported.find(anchor.record.id);
  if (stood != passage.unsupported.end()) anchor.record.map_from_anchor = stood->second;
}

/// The anchor is about to be compared or changed, as the live release shows it.
void SessionState::Settle(Room& room, const AnchorId& id) {
  if (!room.passage) return;
  RoomAnchor* const anchor = room.Find(id);
  if (anchor == nullptr || anchor->record.epoch == map_.epoch) return;
  SetInLiveMap(*anchor, *room.passage);
  room.passage->again.insert(id);
}

}  // namespace waymark::session
