// SPDX-License-Identifier: Apache-2.0
// What becomes of anchor commands: decided, written, published, answered, in this order.
#include <fmt/format.h>

#include "session/state/session_state.h"

namespace waymark::session {
namespace {

constexpr std::size_t kRememberedReplies = 64;  // twice what may be under way

}  // namespace

void SessionState::On(const event::CommandReceived& event, Step& step) {
  const AnchorCommand command = InLiveMap(event.command);
  RoomMember* const member = FindHeard(command.ticket, step.now);
  if (member == nullptr || member->under_way.contains(command.request)) return;
  Settle(rooms_.at(member->room), command.anchor);
  if (const CommandReply* const answer = member->FindAnswer(command.request)) {
    CommandReply reply = *answer;
    const RoomAnchor* const current = rooms_.at(member->room).Find(reply.anchor, member->owner());
    if (current != nullptr) reply.current = *current;
    step.effects.push_back(effect::SendReply{std::move(reply)});
    return;
  }
  if (member->under_way.size() >= options_.max_writes_per_device) {
    // Not remembered: the repetition may find room.
    step.effects.push_back(effect::SendReply{
        {.device = member->device,
         .request = command.request,
         .outcome = CommandOutcome::kUnavailable,
         .reason = fmt::format("{} commands of this device wait already", member->under_way.size()),
         .anchor = command.anchor,
         .current = std::nullopt}});
    return;
  }
  Room& room = rooms_.at(member->room);
  auto decision = DecideCommand(command, *member, room,
                                {.rights = options_.rights,
                                 .max_anchors = options_.max_anchors,
                                 .max_own_anchors = options_.max_own_anchors,
                                 .live_epoch = map_.epoch});
  if (const auto* verdict = std::get_if<CommandVerdict>(&decision)) {
    return Answer(*member, command.request, command.anchor, *verdict, step);
  }
  auto& intended = std::get<IntendedWrite>(decision);
  const WriteNumber number{next_write_++};
  step.effects.push_back(effect::WriteAnchor{.write = number,
                                             .operation = command.operation,
                                             .record = intended.record,
                                             .expected_revision = intended.expected_revision,
                                             .seen_in = command.seen_in});
  member->under_way.insert(command.request);
  ++room.writes_under_way;
  writes_.emplace(number, PendingWrite{member->device, member->owner(), command.request,
                                       command.operation, std::move(intended.record)});
}

void SessionState::On(const event::WriteFinished& event, Step& step) {
  const auto found = writes_.find(event.write);
  if (found == writes_.end()) return;
  const PendingWrite write = std::move(found->second);
  writes_.erase(found);
  const RoomId& id = write.intended.room;
  Room& room = rooms_.at(id);  // rooms stay while something is written
  --room.writes_under_way;
  room.last_used = step.now;

  CommandVerdict verdict;
  if (!event.outcome.ok()) {
    verdict = {CommandOutcome::kUnavailable, ToString(event.outcome.error()), std::nullopt};
  } else if (const auto* applied = std::get_if<event::WriteFinished::Applied>(&*event.outcome)) {
    const RoomAnchor written = InLiveMap(applied->anchor);
    Acknowledge(room, write, written, step);
    if (write.operation != AnchorOperation::kDelete) verdict.current = written;
  } else {
    auto current = std::get<event::WriteFinished::Conflict>(*event.outcome).current;
    const bool is_seen =
        current && (IsForTheRoom(current->record) || current->record.owner == write.owner);
    if (is_seen) {
      current = InLiveMap(*current);
    } else {
      current.reset();
    }
    verdict = DecideConflict(write.operation, write.intended, current);
  }
  RoomMember* const member = FindKnown(write.device);
  if (member == nullptr) return;  // left meanwhile; what was written stays
  member->under_way.erase(write.request);
  Answer(*member, write.request, write.intended.id, verdict, step);
}

// What the store's feed has told already, and what came after it, is not to be told again.
void SessionState::Acknowledge(Room& room, const PendingWrite& write, const RoomAnchor& written,
                               Step& step) {
  const std::uint64_t revision = written.record.revision;
  if (revision <= room.followed) return;
  if (write.operation == AnchorOperation::kDelete) {
    room.removed.insert(write.intended.id);
    Hide(room, write.intended.room, write.intended.id, revision, step);
  } else {
    Show(room, written, step);
  }
  PublishState(write.intended.room, room, step);
}

void SessionState::Answer(RoomMember& member, const Uuid& request, const AnchorId& anchor,
                          const CommandVerdict& verdict, Step& step) {
  CommandReply reply{.device = member.device,
                     .request = request,
                     .outcome = verdict.outcome,
                     .reason = verdict.reason,
                     .anchor = anchor,
                     .current = std::nullopt};
  if (verdict.outcome != CommandOutcome::kUnavailable) {  // a repetition may fare better
    member.answered.push_back(reply);  // without the anchor: memory stays small whatever it carries
    if (member.answered.size() > kRememberedReplies) member.answered.pop_front();
  }
  reply.current = verdict.current;
  step.effects.push_back(effect::SendReply{std::move(reply)});
}

}  // namespace waymark::session
