// SPDX-License-Identifier: Apache-2.0
// Who is still there and where; joining is in session_joining.cc, commands in session_commands.cc.
#include "session/state/session_state.h"

#include <utility>

namespace waymark::session {
namespace {

constexpr std::size_t kMembersOfCrowd = 64;  // to whom frames at once would take a millisecond
constexpr std::chrono::milliseconds kLooksAroundEvery{25};

}  // namespace

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

SessionState::SessionState(const StateOptions& options, RunId run, const MapIdentity& map,
                           std::shared_ptr<const Placements> placements)
    : options_(options), run_(run), map_(map), placements_(std::move(placements)) {}

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

void SessionState::On(const event::Heard& event, Step& step) {
  (void)FindHeard(event.ticket, step.now);
}

void SessionState::On(const event::PoseReceived& event, Step& step) {
  RoomMember* const member = FindHeard(event.report.ticket, step.now);
  if (member == nullptr || !MaySharePose(member->role())) return;
  const LivePose& pose = event.report.pose;
  const bool is_plausible = pose.epoch == map_.epoch &&
                            pose.time <= step.now + options_.max_clock_error &&
                            pose.time >= step.now - options_.max_clock_error;
  // A pose from the future of a clock that was set back since does not hide later ones.
  const bool is_newer = !member->pose || pose.time > member->pose->time ||
                        member->pose->time > step.now + options_.max_clock_error;
  if (!is_plausible || !is_newer) return;
  member->pose = pose;
  WantPublished(*member);
}

void SessionState::On(const event::Ticked&, Step& step) {
  ++tick_;
  const bool is_clock_set_back = step.now < looked_around_;
  if (step.now - looked_around_ >= kLooksAroundEvery || is_clock_set_back) LookAround(step);
  for (auto& [id, room] : rooms_) PublishPoses(id, room, step);
  CarryOn(step);
}

void SessionState::LookAround(Step& step) {
  looked_around_ = step.now;
  RemoveSilent(step);
  EndPermits(step);
  ForgetAbsent(step);
  CloseIdleRooms(step);
  TellOwnDue(step);
  for (auto& [device, member] : members_) {
    const bool is_told_long_ago = step.now - member.pose_published > options_.pose_repeat;
    if (member.pose && is_told_long_ago) WantPublished(member);
  }
}

void SessionState::CloseIdleRooms(Step& step) {
  for (auto room = rooms_.begin(); room != rooms_.end();) {
    const bool is_idle = room->second.is_open && room->second.members.empty() &&
                         room->second.away.empty() && room->second.writes_under_way == 0 &&
                         step.now - room->second.last_used > options_.room_idle;
    if (is_idle) step.effects.push_back(effect::CloseRoom{room->first});
    room = is_idle ? rooms_.erase(room) : std::next(room);
  }
}

// A pose goes out once when it is new, and again now and then in case it was lost or somebody
// joined since.
void SessionState::WantPublished(RoomMember& member) {
  if (std::exchange(member.pose_is_due, true)) return;
  rooms_.at(member.room).poses_due.push_back(member.device);
}

// Where many listen at every tick, elsewhere once in the period of a frame.
void SessionState::PublishPoses(const RoomId& id, Room& room, Step& step) {
  const bool is_crowd = room.members.size() > kMembersOfCrowd;
  if (!is_crowd && tick_ - room.poses_told < kTicksPerFrame) return;
  std::vector<SharedPose> poses;
  for (const DeviceId& device : std::exchange(room.poses_due, {})) {
    const auto member = members_.find(device);
    // It may have left, or come back without a pose, since.
    if (member == members_.end() || !std::exchange(member->second.pose_is_due, false)) continue;
    poses.push_back({member->second.number, *member->second.pose});
    member->second.pose_published = step.now;
  }
  if (poses.empty()) return;
  room.poses_told = tick_;
  step.effects.push_back(effect::PublishPoses{
      .room = id, .run = run_, .tick = tick_, .epoch = map_.epoch, .poses = std::move(poses)});
}

// What is told already is not told again: that something private changed is nobody else's concern.
void SessionState::PublishState(const RoomId& id, Room& room, Step& step) {
  const RoomState state{.room = id,
                        .run = run_,
                        .revision = room.shared.revision,
                        .epoch = map_.epoch,
                        .anchor_count = static_cast<std::uint32_t>(room.shared.anchors.size()),
                        .anchor_digest = room.shared.digest};
  if (room.told != state) {
    room.told = state;
    step.effects.push_back(effect::PublishRoomState{state});
  }
  PublishAreas(room, step);
}

}  // namespace waymark::session
