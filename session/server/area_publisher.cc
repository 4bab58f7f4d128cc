// SPDX-License-Identifier: Apache-2.0
#include "session/server/area_publisher.h"

#include "session/server/internal/log_failure.h"

namespace waymark::session {

void AreaPublisher::Do(const effect::TellArea& effect, ServerTime now) {
  const DeviceId& device = effect.device;
  for (const AnchorState& state : effect.anchors) {
    ended_.erase({device, state.anchor.record.id});
    LogFailure(bus_.SendInArea(device, state));
  }
  for (const AnchorId& anchor : effect.over) {
    ended_.insert_or_assign({device, anchor}, now);
    bus_.WithdrawInArea(device, anchor);
  }
  for (const AnchorId& anchor : effect.leaving) bus_.ForgetInArea(device, anchor);
  if (effect.state) LogFailure(bus_.SendInArea(device, *effect.state));
}

void AreaPublisher::Forget(const DeviceId& device) {
  bus_.ForgetArea(device);
  std::erase_if(ended_, [&](const auto& entry) { return entry.first.first == device; });
}

void AreaPublisher::Tend(ServerTime now, std::chrono::nanoseconds memory_of_ends) {
  std::erase_if(ended_, [&](const auto& entry) {
    if (now - entry.second < memory_of_ends) return false;
    bus_.ForgetInArea(entry.first.first, entry.first.second);
    return true;
  });
}

}  // namespace waymark::session
