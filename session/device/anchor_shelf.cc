// SPDX-License-Identifier: Apache-2.0
#include "session/device/anchor_shelf.h"

#include "session/state/carrying.h"

namespace waymark::session {

void AnchorShelf::StartRun(RunId run, std::uint64_t epoch) {
  epoch_ = epoch;
  for (auto& [id, held] : anchors_) held.shown = held.anchor;
  if (run == run_) return;
  run_ = run;
  is_complete_ = false;
  CountAnew();  // what of the new run is here already, before its welcome
  Check();
}

void AnchorShelf::CountAnew() {
  of_run_ = {};
  of_delivery_ = {};
  for (const auto& [id, held] : anchors_) Count(held, true);
}

void AnchorShelf::BeginResync() {
  ++delivery_;
  is_complete_ = false;
  of_delivery_ = {};
  Check();
}

void AnchorShelf::Lose(const AnchorId& anchor) {
  const auto found = anchors_.find(anchor);
  if (found == anchors_.end()) return;
  Count(found->second, false);
  found->second.delivery = 0;
  Count(found->second, true);
  is_complete_ = false;
  Check();
}

void AnchorShelf::Expect(RunId run, const Tally& all, const std::optional<AnchorArea>& area) {
  expected_ = {run, all};
  if (area) {
    area_ = area;
    std::erase_if(anchors_, [&](const auto& entry) { return !Shows(entry.second); });
    is_complete_ = false;
    CountAnew();
  }
  Check();
}

void AnchorShelf::Count(const Held& held, bool is_added) {
  if (held.run != run_ || !Shows(held)) return;
  const std::uint64_t digest = AnchorDigest(held.anchor.record.id, held.anchor.record.revision);
  const auto count = [&](Tally& tally) {
    tally.count += is_added ? 1 : -1;
    tally.digest ^= digest;
  };
  count(of_run_);
  if (held.delivery == delivery_) count(of_delivery_);
}

void AnchorShelf::CarryTo(std::uint64_t epoch, const Placements& placements) {
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

void AnchorShelf::Hold(RunId run, const RoomAnchor& anchor) {
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
  const Held held{run, anchor, std::move(shown), delivery_};
  Count(held, true);
  anchors_.insert_or_assign(id, held);
}

void AnchorShelf::Put(RunId run, const RoomAnchor& anchor) {
  deleted_.erase(anchor.record.id);
  Hold(run, anchor);
  Check();
}

void AnchorShelf::PutOwnChange(const RoomAnchor& anchor) {
  if (deleted_.contains(anchor.record.id)) return;
  Hold(run_, anchor);
  Check();
}

void AnchorShelf::Remove(const AnchorId& anchor) {
  deleted_.insert(anchor);
  const auto found = anchors_.find(anchor);
  if (found == anchors_.end()) return;
  Count(found->second, false);
  anchors_.erase(found);
  Check();
}

const AnchorShelf::Held* AnchorShelf::Find(const AnchorId& anchor) const {
  const auto found = anchors_.find(anchor);
  return found == anchors_.end() ? nullptr : &found->second;
}

bool AnchorShelf::Agrees(const Tally& tally) const {
  return tally.count == expected_->all.count && tally.digest == expected_->all.digest;
}

void AnchorShelf::Check() {
  if (!expected_ || expected_->run != run_) return;
  const bool all_agree = Agrees(of_run_);
  if (!all_agree && !Agrees(of_delivery_)) return;
  is_complete_ = true;
  if (!all_agree) of_run_ = of_delivery_;
  if (anchors_.size() == of_run_.count) return;
  std::erase_if(anchors_, [&](const auto& entry) {
    const Held& held = entry.second;
    return held.run != run_ || (!all_agree && held.delivery != delivery_);
  });
}

}  // namespace waymark::session
