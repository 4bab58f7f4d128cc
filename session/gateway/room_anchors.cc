// SPDX-License-Identifier: Apache-2.0
// Who is told which anchors.
#include "session/gateway/room.h"
#include "session/wire/frames.h"

namespace waymark::session::internal {

void Room::On(const AnchorState& state, const wire::SharedFrame& frame) {
  const std::uint64_t epoch = state.anchor.record.epoch;
  const auto [entry, is_new] = anchors_.try_emplace(state.anchor.record.id);
  if (!is_new) ForgetAnchor(entry->second);
  entry->second = {{state.run, frame}, epoch};
  ++anchors_of_epochs_[epoch];
  TellOfAnchor(anchor_relay_.Put(state), frame);
}

void Room::On(const wire::AnchorGone& gone, const wire::SharedFrame& frame) {
  if (const auto known = anchors_.find(gone.anchor); known != anchors_.end()) {
    ForgetAnchor(known->second);
    anchors_.erase(known);
  }
  TellOfAnchor(anchor_relay_.Remove(gone.anchor), frame);
}

void Room::TellOfAnchor(const AnchorRelay::Change& change, const wire::SharedFrame& frame) {
  for (const auto& [phone, pose_listener] : phones_) {
    if (!by_area_.contains(phone)) phone->Tell(frame, std::nullopt);
  }
  for (auto& [phone, listener] : by_area_) {
    if (listener.Concerns(change)) phone->Tell(frame, std::nullopt);
  }
}

void Room::ForgetAnchor(const AnchorWord& word) {
  const auto of_epoch = anchors_of_epochs_.find(word.epoch);
  if (--of_epoch->second == 0) anchors_of_epochs_.erase(of_epoch);
}

bool Room::IsOfOneRelease() const {
  return anchors_of_epochs_.empty() ||
         (anchors_of_epochs_.size() == 1 && anchors_of_epochs_.contains(epoch_));
}

void Room::TellAreaState(const PhonePtr& phone, AnchorRelay::Listener& listener) {
  const auto state = listener.TakeState(anchor_relay_);
  if (!state) return;
  const wire::Downward message(*state);
  phone->Tell(wire::Share(wire::EncodeFrame(message)), wire::SlotOf(message));
}

void Room::SetArea(const PhonePtr& phone, const AreaReport& report) {
  const std::lock_guard lock(mutex_);
  if (phone->anchor_scope() != AnchorScope::kArea) return;
  // On the way to another release some anchors would be wrong by where the phone's map is now. It
  // asks again.
  if (!IsOfOneRelease()) return;
  AnchorRelay::Listener& listener =
      by_area_.try_emplace(phone, AnchorRelay::Listener(*phone->device())).first->second;
  for (const AnchorId& anchor : anchor_relay_.Listen(listener, report).coming) {
    phone->Tell(anchors_.at(anchor).frame, std::nullopt);
  }
  TellAreaState(phone, listener);
}

// ---- what an owner alone may see --------------------------------------------------------------

bool Room::HearOwn(const wire::Downward& message, const wire::SharedFrame& frame) {
  if (const auto* const state = std::get_if<AnchorState>(&message)) {
    if (state->anchor.record.visibility != content::AnchorVisibility::kPrivate) return false;
    OnOwn(*state, frame);
  } else if (const auto* const gone = std::get_if<wire::AnchorGone>(&message)) {
    if (!gone->is_own) return false;
    OnOwn(*gone, frame);
  } else if (const auto* const of_owner = std::get_if<OwnerState>(&message)) {
    OnOwn(*of_owner, frame);
  } else {
    return false;
  }
  return true;
}

void Room::OnOwn(const AnchorState& state, const wire::SharedFrame& frame) {
  const std::string& owner = state.anchor.record.owner;
  if (!by_owner_.contains(owner)) return;  // its phones are at other gateways
  own_[owner].anchors.insert_or_assign(state.anchor.record.id, Word{state.run, frame});
  TellOwner(owner, frame);
}

void Room::OnOwn(const wire::AnchorGone& gone, const wire::SharedFrame& frame) {
  for (auto& [owner, words] : own_) {
    if (words.anchors.erase(gone.anchor) > 0) TellOwner(owner, frame);
  }
}

void Room::OnOwn(const OwnerState& state, const wire::SharedFrame& frame) {
  if (!by_owner_.contains(state.owner)) return;
  own_[state.owner].state = {state.run, frame};
  TellOwner(state.owner, frame);
}

// Only those whom the server has let in: others may say what they like of themselves.
void Room::TellOwner(const std::string& owner, const wire::SharedFrame& frame) {
  const auto [begin, end] = by_owner_.equal_range(owner);
  for (auto entry = begin; entry != end; ++entry) {
    if (phones_.contains(entry->second)) entry->second->Tell(frame, std::nullopt);
  }
}

}  // namespace waymark::session::internal
