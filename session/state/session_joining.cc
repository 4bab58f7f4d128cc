// SPDX-License-Identifier: Apache-2.0
// Who is in which room.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "session/state/session_state.h"

namespace waymark::session {

void SessionState::On(const event::HelloReceived& event, Step& step) {
  const Hello& hello = event.hello;
  if (hello.protocol == 0) {
    Refuse(hello, JoinVerdict::kInvalid,
           fmt::format("expected protocol {} or later, found 0", kProtocol), step);
    return;
  }
  if (const auto found = members_.find(hello.device); found != members_.end()) {
    if (found->second.room == hello.room) {
      found->second.last_heard = step.now;
      Greet(found->second, hello.attempt, step);
      return;
    }
    Remove(hello.device, step);
  }
  const auto room = rooms_.find(hello.room);
  if (room != rooms_.end() && room->second.is_open) return Admit(event, step);
  if (room == rooms_.end()) {
    if (rooms_.size() >= options_.max_rooms) {
      Refuse(hello, JoinVerdict::kRefused,
             fmt::format("the server holds its {} rooms already", options_.max_rooms), step);
      return;
    }
    step.effects.push_back(effect::LoadRoom{hello.room});
  }
  Room& opening = rooms_[hello.room];
  opening.last_used = step.now;
  const auto repeated = std::find_if(
      opening.waiting.begin(), opening.waiting.end(),
      [&](const event::HelloReceived& waiting) { return waiting.hello.device == hello.device; });
  if (repeated != opening.waiting.end()) {
    *repeated = event;
  } else if (opening.waiting.size() < options_.max_members) {
    opening.waiting.push_back(event);
  }
}

void SessionState::Admit(const event::HelloReceived& event, Step& step) {
  const Hello& hello = event.hello;
  Room& room = rooms_.at(hello.room);
  if (room.members.size() >= options_.max_members) {
    Refuse(hello, JoinVerdict::kRefused,
           fmt::format("room {}: holds its {} devices already", hello.room.text(),
                       options_.max_members),
           step);
    return;
  }
  RoomMember member{.device = hello.device,
                    .room = hello.room,
                    .name = hello.name,
                    .ticket = event.fresh_ticket,
                    .number = DeviceNumber{next_number_++},
                    .last_heard = step.now,
                    .pose = std::nullopt,
                    .pose_is_new = false,
                    .pose_published = {},
                    .under_way = {},
                    .answered = {}};
  Greet(member, hello.attempt, step);
  step.effects.push_back(effect::PublishPresence{
      hello.room, Presence{member.device, member.number, member.name, run_}});
  room.members.insert(hello.device);
  room.last_used = step.now;
  tickets_.emplace(member.ticket, hello.device);
  members_.emplace(hello.device, std::move(member));
}

void SessionState::Greet(const RoomMember& member, std::uint32_t attempt, Step& step) {
  step.effects.push_back(effect::SendWelcome{member.room, Welcome{.device = member.device,
                                                                  .attempt = attempt,
                                                                  .verdict = JoinVerdict::kAccepted,
                                                                  .reason = "",
                                                                  .run = run_,
                                                                  .ticket = member.ticket,
                                                                  .number = member.number,
                                                                  .map = map_,
                                                                  .session_time = step.now}});
}

void SessionState::Refuse(const Hello& hello, JoinVerdict verdict, const std::string& reason,
                          Step& step) {
  step.effects.push_back(effect::SendWelcome{hello.room, Welcome{.device = hello.device,
                                                                 .attempt = hello.attempt,
                                                                 .verdict = verdict,
                                                                 .reason = reason,
                                                                 .run = run_,
                                                                 .ticket = {},
                                                                 .number = {},
                                                                 .map = map_,
                                                                 .session_time = step.now}});
  step.effects.push_back(effect::CloseDevice{hello.device});
}

void SessionState::On(const event::RoomLoaded& event, Step& step) {
  const auto found = rooms_.find(event.room);
  if (found == rooms_.end() || found->second.is_open) return;
  Room& room = found->second;
  const std::vector<event::HelloReceived> waiting = std::move(room.waiting);
  if (!event.revision.ok()) {
    rooms_.erase(found);
    for (const event::HelloReceived& hello : waiting) {
      Refuse(hello.hello, JoinVerdict::kUnavailable, ToString(event.revision.error()), step);
    }
    return;
  }
  room.is_open = true;
  room.waiting.clear();
  room.revision = room.followed = *event.revision;
  step.effects.push_back(effect::OpenRoom{event.room});
  for (const RoomAnchor& loaded : event.anchors) Show(room, InLiveMap(loaded), step);
  for (const content::AnchorChange& change : std::exchange(room.early, {})) {
    Follow(room, change, step);
  }
  PublishState(event.room, room, step);
  for (const event::HelloReceived& hello : waiting) Admit(hello, step);
}

void SessionState::On(const event::DeviceLeft& event, Step& step) {
  if (members_.contains(event.device)) {
    Remove(event.device, step);
    return;
  }
  for (auto& [id, room] : rooms_) {
    std::erase_if(room.waiting, [&](const event::HelloReceived& waiting) {
      return waiting.hello.device == event.device;
    });
  }
}

void SessionState::Remove(const DeviceId& device, Step& step) {
  const auto found = members_.find(device);
  const RoomMember& member = found->second;
  Room& room = rooms_.at(member.room);
  room.members.erase(device);
  room.last_used = step.now;
  step.effects.push_back(effect::WithdrawPresence{member.room, device});
  step.effects.push_back(effect::CloseDevice{device});
  tickets_.erase(member.ticket);
  members_.erase(found);
}

}  // namespace waymark::session
