// SPDX-License-Identifier: Apache-2.0
#include "session/server/owner_publisher.h"

#include <algorithm>

#include "session/server/internal/log_failure.h"

namespace waymark::session {

void OwnerPublisher::Do(const effect::SendOwn& effect, ServerTime now) {
  Told& told = told_[effect.device];
  told.owner = effect.state.owner;
  std::set<AnchorId> over = told.anchors;
  for (const AnchorState& state : effect.anchors) over.erase(state.anchor.record.id);
  for (const AnchorId& anchor : over) End(effect.device, anchor, now);
  for (const AnchorState& state : effect.anchors) Show(effect.device, state);
  LogFailure(bus_.Send(effect.device, effect.state));
}

void OwnerPublisher::Do(const effect::SendOwnChange& effect, ServerTime now) {
  if (const auto* const state = std::get_if<AnchorState>(&effect.change)) {
    Show(effect.device, *state);
  } else {
    End(effect.device, std::get<AnchorId>(effect.change), now);
  }
  LogFailure(bus_.Send(effect.device, effect.state));
}

void OwnerPublisher::Show(const DeviceId& device, const AnchorState& state) {
  Told& told = told_[device];
  const AnchorId& anchor = state.anchor.record.id;
  told.anchors.insert(anchor);
  told.ended.erase(anchor);
  LogFailure(bus_.Send(device, state));
}

void OwnerPublisher::End(const DeviceId& device, const AnchorId& anchor, ServerTime now) {
  Told& told = told_[device];
  if (told.anchors.erase(anchor) == 0) return;
  told.ended.insert_or_assign(anchor, now);
  LogFailure(bus_.Withdraw(device, anchor));
}

void OwnerPublisher::Forget(const DeviceId& device) {
  const auto found = told_.find(device);
  if (found == told_.end()) return;
  const Told told = std::move(found->second);
  told_.erase(found);
  const bool others_hear_it = std::ranges::any_of(told_, [&](const auto& other) {
    return other.second.owner == told.owner && bus_.ShareTheirWay(device, other.first);
  });
  if (others_hear_it) return;
  for (const AnchorId& anchor : told.anchors) bus_.Forget(device, anchor);
  for (const auto& [anchor, since] : told.ended) bus_.Forget(device, anchor);
  bus_.Forget(device, told.owner);
}

void OwnerPublisher::Tend(ServerTime now, std::chrono::nanoseconds memory_of_ends) {
  for (auto& [device, told] : told_) {
    std::erase_if(told.ended, [&](const auto& entry) {
      if (now - entry.second < memory_of_ends) return false;
      bus_.Forget(device, entry.first);
      return true;
    });
  }
}

}  // namespace waymark::session
