// SPDX-License-Identifier: Apache-2.0
// Who is in which room; commands are in session_commands.cc.
#include "session/state/session_state.h"

#include <fmt/format.h>

#include <algorithm>

namespace waymark::session {

void Room::Put(const RoomAnchor& anchor) {
  const std::uint64_t new_revision = anchor.record.revision;
  if (const auto found = anchors.find(anchor.record.id); found != anchors.end()) {
    if (found->second.record.revision > new_revision) return;
    digest ^= AnchorDigest(anchor.record.id, found->second.record.revision);
  }
  anchors.insert_or_assign(anchor.record.id, anchor);
  digest ^= AnchorDigest(anchor.record.id, new_revision);
  revision = std::max(revision, new_revision);
}

void Room::Remove(const AnchorId& anchor, std::uint64_t revision_of_deletion) {
  if (const auto found = anchors.find(anchor); found != anchors.end()) {
    digest ^= AnchorDigest(anchor, found->second.record.revision);
    anchors.erase(found);
  }
  revision = std::max(revision, revision_of_deletion);
}

Result<void> StateOptions::Validate() const {
  if (presence_timeout < std::chrono::milliseconds(100)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "presence timeout: expected at least 0.1 s, found {} s",
                     Seconds(presence_timeout));
  }
  if (max_rooms == 0 || max_members == 0 || max_writes_per_device == 0) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "session limits: expected at least 1 room, member and write");
  }
  return {};
}

SessionState::SessionState(const StateOptions& options, RunId run, const MapIdentity& map)
    : options_(options), run_(run), map_(map) {}

std::vector<Effect> SessionState::Apply(const Event& event, ServerTime now) {
  Step step{now, {}};
  std::visit([&](const auto& happened) { On(happened, step); }, event);
  return std::move(step.effects);
}

const RoomMember* SessionState::FindMember(Ticket ticket) const {
  const auto found = tickets_.find(ticket);
  return found == tickets_.end() ? nullptr : &members_.at(found->second);
}

RoomMember* SessionState::FindHeard(Ticket ticket, ServerTime now) {
  const auto found = tickets_.find(ticket);
  if (found == tickets_.end()) return nullptr;
  RoomMember& member = members_.at(found->second);
  member.last_heard = now;
  return &member;
}

// ---- joining and leaving ----------------------------------------------------------------------

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
  room.revision = *event.revision;
  step.effects.push_back(effect::OpenRoom{event.room});
  for (const RoomAnchor& anchor : event.anchors) {
    room.Put(anchor);
    step.effects.push_back(effect::PublishAnchor{event.room, AnchorState{run_, anchor}});
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

// ---- living -----------------------------------------------------------------------------------

void SessionState::On(const event::Heard& event, Step& step) {
  (void)FindHeard(event.ticket, step.now);
}

void SessionState::On(const event::PoseReceived& event, Step& step) {
  RoomMember* const member = FindHeard(event.report.ticket, step.now);
  if (member == nullptr) return;
  const LivePose& pose = event.report.pose;
  const bool is_plausible = pose.epoch == map_.epoch &&
                            pose.time <= step.now + options_.max_clock_error &&
                            pose.time >= step.now - options_.max_clock_error;
  const bool is_newer = !member->pose || pose.time > member->pose->time;
  if (!is_plausible || !is_newer) return;
  member->pose = pose;
  member->pose_is_new = true;
}

void SessionState::On(const event::Ticked&, Step& step) {
  ++tick_;
  RemoveSilent(step);
  CloseIdleRooms(step);
  for (const auto& [id, room] : rooms_) PublishPoses(id, room, step);
}

void SessionState::RemoveSilent(Step& step) {
  std::vector<DeviceId> silent;
  for (const auto& [device, member] : members_) {
    if (step.now - member.last_heard > options_.presence_timeout) silent.push_back(device);
  }
  for (const DeviceId& device : silent) Remove(device, step);
}

void SessionState::CloseIdleRooms(Step& step) {
  for (auto room = rooms_.begin(); room != rooms_.end();) {
    const bool is_idle = room->second.is_open && room->second.members.empty() &&
                         room->second.writes_under_way == 0 &&
                         step.now - room->second.last_used > options_.room_idle;
    if (is_idle) step.effects.push_back(effect::CloseRoom{room->first});
    room = is_idle ? rooms_.erase(room) : std::next(room);
  }
}

// A pose goes out once when it is new, and again now and then in case it was lost or somebody
// joined since.
void SessionState::PublishPoses(const RoomId& id, const Room& room, Step& step) {
  PoseBatch batch{.chunk = 0, .tick = tick_, .run = run_, .poses = {}};
  const auto publish = [&] {
    if (batch.poses.empty()) return;
    step.effects.push_back(effect::PublishPoses{id, batch});
    batch.poses.clear();
    ++batch.chunk;
  };
  for (const DeviceId& device : room.members) {
    RoomMember& member = members_.at(device);
    const bool is_due = member.pose_is_new ||
                        (member.pose && step.now - member.pose_published > options_.pose_repeat);
    if (!is_due) continue;
    batch.poses.push_back({member.number, *member.pose});
    member.pose_is_new = false;
    member.pose_published = step.now;
    if (batch.poses.size() == kMaxPosesPerBatch) publish();
  }
  publish();
}

void SessionState::PublishState(const RoomId& id, const Room& room, Step& step) {
  step.effects.push_back(effect::PublishRoomState{
      RoomState{.room = id,
                .run = run_,
                .revision = room.revision,
                .epoch = map_.epoch,
                .anchor_count = static_cast<std::uint32_t>(room.anchors.size()),
                .anchor_digest = room.digest}});
}

}  // namespace waymark::session
