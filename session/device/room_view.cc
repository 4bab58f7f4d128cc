// SPDX-License-Identifier: Apache-2.0
#include "session/device/room_view.h"

namespace waymark::session {
namespace {

constexpr std::chrono::seconds kRemembersLeavers{30};

}  // namespace

SharedAnchor ToShared(const RoomAnchor& anchor) {
  const content::AnchorRecord& record = anchor.record;
  return {.id = record.id,
          .owner = DeviceId(record.owner),
          .map_from_anchor = record.map_from_anchor,
          .epoch = record.epoch,
          .revision = record.revision,
          .kind = record.kind,
          .payload = record.payload,
          .is_supported = anchor.is_supported,
          .audience = record.visibility};
}

void RoomView::StartRun(RunId run, std::uint64_t epoch) {
  for (AnchorShelf* const shelf : {&room_, &own_}) shelf->StartRun(run, epoch);
  if (run == run_) return;
  run_ = run;
  numbers_.clear();
  // What of the new run is here already, before its welcome.
  for (const auto& [device, other] : others_) {
    if (other.presence.run == run_) numbers_.emplace(other.presence.number, device);
  }
}

void RoomView::BeginResync() {
  ++delivery_;
  for (AnchorShelf* const shelf : {&room_, &own_}) shelf->BeginResync();
}

void RoomView::OnLost(const DeviceId& device) {
  if (const auto found = others_.find(device); found != others_.end()) found->second.delivery = 0;
}

// ---- others -----------------------------------------------------------------------------------

void RoomView::On(const Presence& presence) {
  if (presence.device == self_) return;
  others_.insert_or_assign(presence.device,
                           Other{presence, RemoteTrack(), std::nullopt, delivery_});
  if (presence.run == run_) numbers_.insert_or_assign(presence.number, presence.device);
}

void RoomView::OnGone(const DeviceId& device, ServerTime now) {
  const auto found = others_.find(device);
  if (found == others_.end()) return;
  numbers_.erase(found->second.presence.number);
  found->second.gone_since = now;
  std::erase_if(others_, [&](const auto& entry) {
    return entry.second.gone_since && now - *entry.second.gone_since > kRemembersLeavers;
  });
}

void RoomView::On(const PoseBatch& batch, ServerTime now) {
  if (batch.run != run_) return;
  for (const SharedPose& shared : batch.poses) {
    const auto number = numbers_.find(shared.number);
    if (number == numbers_.end()) continue;
    Other& other = others_.at(number->second);
    other.track.Hear(shared.pose, now);
    other.delivery = delivery_;
  }
}

std::vector<OtherDevice> RoomView::Others(ServerTime now) const {
  std::vector<OtherDevice> others;
  for (const auto& [device, other] : others_) {
    if (other.gone_since && now - *other.gone_since > kRemembersLeavers) continue;
    OtherDevice& shown = others.emplace_back(OtherDevice{.id = device,
                                                         .name = other.presence.name,
                                                         .is_present = !other.gone_since &&
                                                                       other.presence.run == run_ &&
                                                                       other.delivery == delivery_,
                                                         .map_from_device = std::nullopt,
                                                         .role = other.presence.role});
    const std::optional<RemoteTrack::Shown> at = other.track.At(now);
    if (!at) continue;
    shown.map_from_device = at->map_from_device;
    shown.sigma_m = at->sigma_m;
    shown.rotation_sigma_rad = at->rotation_sigma_rad;
    const LivePose& said = *other.track.latest();
    shown.tracking = said.tracking;
    shown.certainty = {said.sigma_m, said.rotation_sigma_rad};
    shown.epoch = said.epoch;
    shown.age = now - said.time;
  }
  return others;
}

// ---- anchors ----------------------------------------------------------------------------------

AnchorShelf& RoomView::ShelfOf(const RoomAnchor& anchor) {
  return anchor.record.visibility == content::AnchorVisibility::kPrivate ? own_ : room_;
}

void RoomView::CarryTo(std::uint64_t epoch, const Placements& placements) {
  for (AnchorShelf* const shelf : {&room_, &own_}) shelf->CarryTo(epoch, placements);
}

void RoomView::On(const AnchorState& state) { ShelfOf(state.anchor).Put(state.run, state.anchor); }

void RoomView::OnOwnChange(const RoomAnchor& anchor) { ShelfOf(anchor).PutOwnChange(anchor); }

void RoomView::OnGone(const AnchorId& anchor, std::optional<bool> is_own) {
  if (is_own.value_or(own_.Find(anchor) != nullptr)) {
    own_.Remove(anchor);
  } else {
    room_.Remove(anchor);
  }
}

void RoomView::On(const RoomState& state) {
  if (scope_ == AnchorScope::kArea) return;  // counts those elsewhere too
  room_.Expect(state.run, {state.anchor_count, state.anchor_digest});
}

void RoomView::On(const OwnerState& state) {
  own_.Expect(state.run, {state.anchor_count, state.anchor_digest});
}

void RoomView::On(const AreaState& state) {
  if (scope_ != AnchorScope::kArea) return;
  room_.Expect(state.run, {state.anchor_count, state.anchor_digest}, state.area);
}

std::vector<SharedAnchor> RoomView::Anchors() const {
  std::vector<SharedAnchor> anchors;
  anchors.reserve(room_.anchors().size() + own_.anchors().size());
  for (const AnchorShelf* const shelf : {&room_, &own_}) {
    for (const auto& [id, held] : shelf->anchors()) {
      if (shelf->Shows(held) && FindLatest(id) == &held) anchors.push_back(ToShared(held.shown));
    }
  }
  return anchors;
}

std::optional<SharedAnchor> RoomView::FindAnchor(const AnchorId& anchor) const {
  const AnchorShelf::Held* const held = FindLatest(anchor);
  return held == nullptr ? std::nullopt : std::optional(ToShared(held->shown));
}

const AnchorShelf::Held* RoomView::FindLatest(const AnchorId& anchor) const {
  const AnchorShelf::Held* const shared = room_.Find(anchor);
  const AnchorShelf::Held* const own = own_.Find(anchor);
  if (shared == nullptr || own == nullptr) return shared == nullptr ? own : shared;
  return own->anchor.record.revision > shared->anchor.record.revision ? own : shared;
}

}  // namespace waymark::session
