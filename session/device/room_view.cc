// SPDX-License-Identifier: Apache-2.0
#include "session/device/room_view.h"

#include "session/state/carrying.h"

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
          .is_supported = anchor.is_supported};
}

void RoomView::StartRun(RunId run, std::uint64_t epoch) {
  epoch_ = epoch;
  for (auto& [id, held] : anchors_) held.shown = held.anchor;
  if (run == run_) return;
  run_ = run;
  has_snapshot_ = false;
  numbers_.clear();
  of_run_ = {};
  of_delivery_ = {};
  // What of the new run is here already, before its welcome.
  for (const auto& [device, other] : others_) {
    if (other.presence.run == run_) numbers_.emplace(other.presence.number, device);
  }
  for (const auto& [id, held] : anchors_) Count(held, true);
  CheckSnapshot();
}

void RoomView::BeginResync() {
  ++delivery_;
  has_snapshot_ = false;
  of_delivery_ = {};
  CheckSnapshot();
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
    shown.epoch = other.track.latest()->epoch;
    shown.age = now - other.track.latest()->time;
  }
  return others;
}

// ---- anchors ----------------------------------------------------------------------------------

void RoomView::Count(const HeldAnchor& held, bool is_added) {
  if (held.run != run_) return;
  const std::uint64_t digest = AnchorDigest(held.anchor.record.id, held.anchor.record.revision);
  const auto count = [&](Tally& tally) {
    tally.count += is_added ? 1 : -1;
    tally.digest ^= digest;
  };
  count(of_run_);
  if (held.delivery == delivery_) count(of_delivery_);
}

void RoomView::CarryTo(std::uint64_t epoch, const Placements& placements) {
  epoch_ = epoch;
  for (auto& [id, held] : anchors_) {
    if (held.anchor.record.epoch == epoch) {
      held.shown = held.anchor;
      continue;
    }
    const RoomAnchor carried = CarryAnchor(held.anchor.record, epoch, placements);
    if (carried.is_supported) held.shown = carried;
  }
}

void RoomView::Hold(RunId run, const RoomAnchor& anchor) {
  const AnchorId& id = anchor.record.id;
  RoomAnchor shown = anchor;
  if (const auto found = anchors_.find(id); found != anchors_.end()) {
    // Another run than the present one is the next one, whose welcome is still on its way.
    const bool is_older =
        found->second.run == run && found->second.anchor.record.revision > anchor.record.revision;
    if (is_older) return;
    Count(found->second, false);
    // In the frame of a release that this device has not heard of yet: it would seem to jump.
    const bool is_early = anchor.record.epoch != epoch_ && found->second.run == run;
    if (is_early) shown = found->second.shown;
  }
  const HeldAnchor held{run, anchor, std::move(shown), delivery_};
  Count(held, true);
  anchors_.insert_or_assign(id, held);
}

void RoomView::On(const AnchorState& state) {
  deleted_.erase(state.anchor.record.id);
  Hold(state.run, state.anchor);
  CheckSnapshot();
}

void RoomView::OnOwnChange(const RoomAnchor& anchor) {
  if (deleted_.contains(anchor.record.id)) return;
  Hold(run_, anchor);
  CheckSnapshot();
}

void RoomView::OnGone(const AnchorId& anchor) {
  deleted_.insert(anchor);
  const auto found = anchors_.find(anchor);
  if (found == anchors_.end()) return;
  Count(found->second, false);
  anchors_.erase(found);
  CheckSnapshot();
}

void RoomView::On(const RoomState& state) {
  room_ = state;
  CheckSnapshot();
}

bool RoomView::Agrees(const Tally& tally) const {
  return tally.count == room_->anchor_count && tally.digest == room_->anchor_digest;
}

void RoomView::CheckSnapshot() {
  if (!room_ || room_->run != run_) return;
  const bool all_agree = Agrees(of_run_);
  if (!all_agree && !Agrees(of_delivery_)) return;
  has_snapshot_ = true;
  if (!all_agree) of_run_ = of_delivery_;
  if (anchors_.size() == of_run_.count) return;
  std::erase_if(anchors_, [&](const auto& entry) {
    const HeldAnchor& held = entry.second;
    return held.run != run_ || (!all_agree && held.delivery != delivery_);
  });
}

std::vector<SharedAnchor> RoomView::Anchors() const {
  std::vector<SharedAnchor> anchors;
  anchors.reserve(anchors_.size());
  for (const auto& [id, held] : anchors_) anchors.push_back(ToShared(held.shown));
  return anchors;
}

std::optional<SharedAnchor> RoomView::FindAnchor(const AnchorId& anchor) const {
  const auto found = anchors_.find(anchor);
  if (found == anchors_.end()) return std::nullopt;
  return ToShared(found->second.shown);
}

}  // namespace waymark::session
