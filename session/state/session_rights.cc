// SPDX-License-Identifier: Apache-2.0
// Who may come and as what; what moderators may do about it is in session_moderating.cc.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "session/state/session_state.h"

namespace waymark::session {
std::optional<std::string> SessionState::FindObjection(const event::HelloReceived& event,
                                                       ServerTime now) const {
  if (!event.permit.refusal.empty()) return event.permit.refusal;
  if (auto ban = FindBan(event, now)) return ban;
  // A token for any device is no proof of being this one, if another token has said so before; nor
  // is its name, if it has another owner.
  const DeviceId& device = event.hello.device;
  const std::string& owner = event.permit.owner.empty() ? device.text() : event.permit.owner;
  const auto proves_less = [&](const RoomMember& known) {
    const bool is_by_less =
        event.permit.token_id != known.permit.token_id && !event.permit.is_for_this_device;
    return is_by_less || owner != known.owner();
  };
  const auto member = members_.find(device);
  const auto away = away_.find(device);
  const bool is_taken = (member != members_.end() && proves_less(member->second)) ||
                        (away != away_.end() && proves_less(away->second.member));
  if (!is_taken) return std::nullopt;
  return fmt::format("device {}: is here by another token or owner", device.text());
}

std::optional<std::string> SessionState::FindBan(const event::HelloReceived& event,
                                                 ServerTime now) const {
  const RoomId& room = event.hello.room;
  const std::string& token = event.permit.token_id;
  for (const auto& [whom, ban] : rules_.bans) {
    if (whom.first != room || ban.until <= now) continue;
    if (whom.second != event.hello.device && (token.empty() || token != ban.token_id)) continue;
    return fmt::format("removed from room {} by a moderator{}; may come back in {:.0f} s",
                       room.text(), ban.reason.empty() ? "" : ": " + ban.reason,
                       std::ceil(Seconds(ban.until - now)));
  }
  return std::nullopt;
}

void SessionState::Renew(RoomMember& member, const event::HelloReceived& event, Step& step) {
  const Role before = member.role();
  member.last_heard = step.now;
  if (member.attempt != event.hello.attempt) member.is_return = true;  // not said once more
  member.attempt = event.hello.attempt;
  member.permit = event.permit;
  Greet(member, step);
  member.is_own_due = true;
  if (member.role() == before) return;
  if (!MaySharePose(member.role())) {
    member.pose.reset();
    member.pose_is_due = false;
  }
  Announce(member, step);
}

void SessionState::SendAway(const DeviceId& device, const std::string& reason, Step& step) {
  (void)TakeAway(device);
  const auto found = members_.find(device);
  if (found == members_.end()) return;
  const RoomMember& member = found->second;
  step.effects.push_back(effect::SendWelcome{member.room, Welcome{.device = device,
                                                                  .attempt = member.attempt,
                                                                  .verdict = JoinVerdict::kRemoved,
                                                                  .reason = reason,
                                                                  .run = run_,
                                                                  .map = map_,
                                                                  .session_time = step.now}});
  Remove(device, step);
}

void SessionState::EndPermits(Step& step) {
  std::vector<DeviceId> ended;
  for (const auto& [device, member] : members_) {
    if (member.permit.until && *member.permit.until < step.now) ended.push_back(device);
  }
  for (const DeviceId& device : ended) SendAway(device, "the token's time is over", step);
}

void SessionState::On(const event::PermitsRevoked& event, Step& step) {
  std::vector<DeviceId> ended;
  const auto is_revoked = [&](const RoomMember& member) {
    return event.token_ids.contains(member.permit.token_id) ||
           event.token_keys.contains(member.permit.token_key) ||
           event.devices.contains(member.device);
  };
  for (const auto& [device, member] : members_) {
    if (is_revoked(member)) ended.push_back(device);
  }
  for (const auto& [device, away] : away_) {
    if (is_revoked(away.member)) ended.push_back(device);
  }
  for (const DeviceId& device : ended) SendAway(device, "the token was revoked", step);
}

}  // namespace waymark::session
