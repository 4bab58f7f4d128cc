// SPDX-License-Identifier: Apache-2.0
// Who is in which room: coming and going. What they may do there is in session_rights.cc.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "session/state/session_state.h"

namespace waymark::session {

void SessionState::On(const event::HelloReceived& event, Step& step) {
  const Hello& hello = event.hello;
  if (hello.protocol < kOldestProtocol) {
    Refuse(hello, JoinVerdict::kInvalid,
           fmt::format("expected an app of protocol {} or later, found {}", kOldestProtocol,
                       hello.protocol),
           step);
    return;
  }
  if (const auto objection = FindObjection(event, step.now)) {
    return Refuse(hello, JoinVerdict::kRefused, *objection, step);
  }
  const auto room = rooms_.find(hello.room);
  const bool is_on_its_way = room != rooms_.end() && room->second.passage;
  if (const auto found = members_.find(hello.device); found != members_.end()) {
    if (found->second.room == hello.room) {
      found->second.last_heard = step.now;
      return is_on_its_way ? Wait(room->second, event, step) : Renew(found->second, event, step);
    }
    Remove(hello.device, step);
  }
  if (room == rooms_.end() || !room->second.is_open) return OpenFor(event, step);
  is_on_its_way ? Wait(room->second, event, step) : Admit(event, step);
}

void SessionState::Admit(const event::HelloReceived& event, Step& step) {
  const Hello& hello = event.hello;
  Room& room = rooms_.at(hello.room);
  const std::size_t anchors = room.shared.anchors.size();
  if (hello.anchor_scope == AnchorScope::kRoom && anchors > options_.max_told_anchors) {
    return Refuse(hello, JoinVerdict::kRefused,
                  fmt::format("room {}: holds {} anchors and tells a device {} at most; join it "
                              "with an area (anchor radius)",
                              hello.room.text(), anchors, options_.max_told_anchors),
                  step);
  }
  std::optional<RoomMember> returning = TakeAway(hello.device);
  if (returning && returning->room == hello.room) {
    returning->name = hello.name;
    returning->attempt = hello.attempt;
    returning->is_return = true;
    returning->permit = event.permit;
    return Seat(*std::move(returning), step);
  }
  const std::uint32_t capacity = CapacityOf(hello.room);
  if (room.members.size() + room.away.size() >= capacity) {
    Refuse(hello, JoinVerdict::kRefused,
           fmt::format("room {}: holds its {} devices already", hello.room.text(), capacity), step);
    return;
  }
  Seat({.device = hello.device,
        .room = hello.room,
        .name = hello.name,
        .ticket = event.fresh_ticket,
        .number = TakeNumber(),
        .last_heard = step.now,
        .pose = std::nullopt,
        .pose_is_due = false,
        .pose_published = {},
        .under_way = {},
        .answered = {},
        .attempt = hello.attempt,
        .permit = event.permit},
       step);
}

/// Not that of anybody who is here or away.
DeviceNumber SessionState::TakeNumber() {
  const auto is_taken = [&](DeviceNumber number) {
    return std::ranges::any_of(members_,
                               [&](const auto& m) { return m.second.number == number; }) ||
           std::ranges::any_of(away_,
                               [&](const auto& a) { return a.second.member.number == number; });
  };
  while (true) {
    const DeviceNumber number{next_number_++ % kDeviceNumbers};
    // Before they come round none is taken.
    if (next_number_ <= kDeviceNumbers || !is_taken(number)) return number;
  }
}

void SessionState::Seat(RoomMember member, Step& step) {
  member.last_heard = step.now;
  Greet(member, step);
  Announce(member, step);
  Room& room = rooms_.at(member.room);
  room.members.insert(member.device);
  room.last_used = step.now;
  tickets_.emplace(member.ticket, member.device);
  const DeviceId device = member.device;
  RoomMember& seated = members_.emplace(device, std::move(member)).first->second;
  TellOwn(seated, step);
}

void SessionState::Greet(const RoomMember& member, Step& step) {
  step.effects.push_back(effect::SendWelcome{member.room, Welcome{.device = member.device,
                                                                  .attempt = member.attempt,
                                                                  .verdict = JoinVerdict::kAccepted,
                                                                  .reason = "",
                                                                  .run = run_,
                                                                  .ticket = member.ticket,
                                                                  .number = member.number,
                                                                  .map = map_,
                                                                  .session_time = step.now,
                                                                  .role = member.role(),
                                                                  .is_return = member.is_return,
                                                                  .owner = member.owner()}});
}

void SessionState::Announce(const RoomMember& member, Step& step) {
  step.effects.push_back(effect::PublishPresence{
      member.room, Presence{member.device, member.number, member.name, run_, member.role()}});
}

// Whoever says a device's name without the right to it must not end what is said to the device,
// nor have it said elsewhere.
void SessionState::Refuse(const Hello& hello, JoinVerdict verdict, const std::string& reason,
                          Step& step) {
  const auto member = members_.find(hello.device);
  if (member != members_.end() && member->second.room != hello.room) return;
  step.effects.push_back(effect::SendWelcome{hello.room, Welcome{.device = hello.device,
                                                                 .attempt = hello.attempt,
                                                                 .verdict = verdict,
                                                                 .reason = reason,
                                                                 .run = run_,
                                                                 .ticket = {},
                                                                 .number = {},
                                                                 .map = map_,
                                                                 .session_time = step.now}});
  if (member == members_.end()) step.effects.push_back(effect::CloseDevice{hello.device});
}

void SessionState::On(const event::DeviceLeft& event, Step& step) {
  for (auto& [id, room] : rooms_) {
    std::erase_if(room.waiting, [&](const event::HelloReceived& waiting) {
      return waiting.hello.device == event.device;
    });
  }
  if (members_.contains(event.device)) {
    return event.said_goodbye ? Remove(event.device, step) : SetAway(event.device, step);
  }
  if (event.said_goodbye) (void)TakeAway(event.device);
}

RoomMember SessionState::Unseat(const DeviceId& device, Step& step) {
  const auto found = members_.find(device);
  RoomMember member = std::move(found->second);
  Room& room = rooms_.at(member.room);
  room.members.erase(device);
  room.listeners.erase(device);
  room.last_used = step.now;
  step.effects.push_back(effect::WithdrawPresence{member.room, device});
  step.effects.push_back(effect::CloseDevice{device});
  tickets_.erase(member.ticket);
  members_.erase(found);
  return member;
}

// ---- away for a while -------------------------------------------------------------------------

void SessionState::SetAway(const DeviceId& device, Step& step) {
  RoomMember member = Unseat(device, step);
  member.pose.reset();
  member.pose_is_due = false;
  rooms_.at(member.room).away.insert(device);
  away_.insert_or_assign(device, AwayMember{std::move(member), step.now});
}

std::optional<RoomMember> SessionState::TakeAway(const DeviceId& device) {
  const auto found = away_.find(device);
  if (found == away_.end()) return std::nullopt;
  RoomMember member = std::move(found->second.member);
  away_.erase(found);
  rooms_.at(member.room).away.erase(device);
  return member;
}

void SessionState::RemoveSilent(Step& step) {
  std::vector<DeviceId> silent;
  for (const auto& [device, member] : members_) {
    if (step.now - member.last_heard > options_.presence_timeout) silent.push_back(device);
  }
  for (const DeviceId& device : silent) SetAway(device, step);
}

void SessionState::ForgetAbsent(Step& step) {
  for (auto away = away_.begin(); away != away_.end();) {
    if (step.now - away->second.since <= options_.return_within) {
      ++away;
      continue;
    }
    Room& room = rooms_.at(away->second.member.room);
    room.away.erase(away->first);
    room.last_used = step.now;
    away = away_.erase(away);
  }
  std::erase_if(rules_.bans, [&](const auto& ban) { return ban.second.until <= step.now; });
}

RoomMember* SessionState::FindKnown(const DeviceId& device) {
  if (const auto member = members_.find(device); member != members_.end()) return &member->second;
  const auto away = away_.find(device);
  return away == away_.end() ? nullptr : &away->second.member;
}

}  // namespace waymark::session
