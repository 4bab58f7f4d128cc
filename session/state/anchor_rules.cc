// SPDX-License-Identifier: Apache-2.0
#include "session/state/anchor_rules.h"

#include <fmt/format.h>

#include "content_store/anchor_rules.h"

namespace waymark::session {
namespace {

bool IsDone(AnchorOperation operation, const content::AnchorRecord& intended,
            const content::AnchorRecord& current) {
  const bool same_pose = IsSamePose(intended.map_from_anchor, current.map_from_anchor);
  if (operation == AnchorOperation::kMove) return same_pose;
  return operation == AnchorOperation::kCreate && same_pose && intended.kind == current.kind &&
         intended.payload == current.payload && intended.owner == current.owner &&
         intended.visibility == current.visibility;
}

content::AnchorRecord NewRecord(const AnchorCommand& command, const RoomMember& member) {
  return {.id = command.anchor,
          .room = member.room,
          .owner = member.owner(),
          .map_from_anchor = command.map_from_anchor,
          .epoch = command.epoch,
          .attachments = {},
          .place = {},
          .kind = command.kind,
          .payload = command.payload,
          .visibility = command.visibility};
}

/// Whether there is no place for one more. Those on their way to the store may be of any kind.
bool IsFull(const Room& room, const content::AnchorRecord& record, const AnchorRules& rules) {
  const std::size_t under_way = room.writes_under_way;
  if (IsForTheRoom(record)) return room.shared.anchors.size() + under_way >= rules.max_anchors;
  const auto own = room.own.find(record.owner);
  const std::size_t held = own == room.own.end() ? 0 : own->second.anchors.size();
  return held + under_way >= rules.max_own_anchors ||
         room.OwnCount() + under_way >= rules.max_anchors;
}

std::variant<CommandVerdict, IntendedWrite> DecideCreation(const AnchorCommand& command,
                                                           const RoomMember& member,
                                                           const Room& room,
                                                           const AnchorRules& rules) {
  const content::AnchorRecord record = NewRecord(command, member);
  if (const RoomAnchor* const found = room.Find(command.anchor, member.owner())) {
    return DecideConflict(AnchorOperation::kCreate, record, *found);
  }
  if (IsFull(room, record, rules)) {
    const bool is_shared = IsForTheRoom(record);
    return CommandVerdict{CommandOutcome::kInvalid,
                          fmt::format("room {}: holds its {} {}anchors already", member.room.text(),
                                      is_shared ? rules.max_anchors : rules.max_own_anchors,
                                      is_shared ? "" : "private "),
                          std::nullopt};
  }
  return IntendedWrite{record, 0};
}

std::variant<CommandVerdict, IntendedWrite> DecideChange(const AnchorCommand& command,
                                                         const RoomMember& member, const Room& room,
                                                         const RoomAnchor& current,
                                                         const AnchorRules& rules) {
  const std::string& owner = member.owner();
  const bool may_edit =
      MayModerate(member.role()) ||
      (content::MayEdit(current.record, member.room, owner) &&
       (rules.rights == AnchorRights::kEveryone || current.record.owner == owner));
  if (!may_edit) {
    return CommandVerdict{
        CommandOutcome::kInvalid,
        fmt::format("anchor {}: belongs to device {}", command.anchor.text(), current.record.owner),
        current};
  }
  content::AnchorRecord record = current.record;
  if (command.operation == AnchorOperation::kMove) {
    record.map_from_anchor = command.map_from_anchor;
    record.epoch = command.epoch;
    record.attachments.clear();
    record.unsupported_since_epoch.reset();
  }
  const AnchorSet& set =
      IsForTheRoom(current.record) ? room.shared : room.own.at(current.record.owner);
  if (!set.IsUpToDate(current, command.expected_revision)) {
    return DecideConflict(command.operation, record, current);
  }
  return IntendedWrite{std::move(record), current.record.revision};
}

}  // namespace

bool IsForTheRoom(const content::AnchorRecord& record) {
  return record.visibility != content::AnchorVisibility::kPrivate;
}

std::variant<CommandVerdict, IntendedWrite> DecideCommand(const AnchorCommand& command,
                                                          const RoomMember& member,
                                                          const Room& room,
                                                          const AnchorRules& rules) {
  if (!MayWriteAnchors(member.role())) {
    return CommandVerdict{CommandOutcome::kForbidden,
                          fmt::format("anchor {}: a viewer of room {} may not write anchors",
                                      command.anchor.text(), member.room.text()),
                          std::nullopt};
  }
  const bool has_pose = command.operation != AnchorOperation::kDelete;
  if (has_pose && command.epoch != rules.live_epoch) {
    return CommandVerdict{CommandOutcome::kConflict,
                          fmt::format("anchor {}: its pose is in map epoch {}, the map is at {}",
                                      command.anchor.text(), command.epoch, rules.live_epoch),
                          std::nullopt};
  }
  if (command.operation == AnchorOperation::kCreate) {
    return DecideCreation(command, member, room, rules);
  }
  const RoomAnchor* const found = room.Find(command.anchor, member.owner());
  if (found == nullptr) {
    return CommandVerdict{
        CommandOutcome::kNotFound,
        fmt::format("anchor {}: room {} has none", command.anchor.text(), member.room.text()),
        std::nullopt};
  }
  return DecideChange(command, member, room, *found, rules);
}

CommandVerdict DecideConflict(AnchorOperation operation, const content::AnchorRecord& intended,
                              const std::optional<RoomAnchor>& current) {
  const std::string id = intended.id.text();
  if (!current) {
    return {CommandOutcome::kNotFound, fmt::format("anchor {}: was deleted", id), std::nullopt};
  }
  if (IsDone(operation, intended, current->record)) {
    return {CommandOutcome::kApplied, "", current};
  }
  return {CommandOutcome::kConflict,
          operation == AnchorOperation::kCreate
              ? fmt::format("anchor {}: exists with other content", id)
              : fmt::format("anchor {}: was changed meanwhile, revision {}", id,
                            current->record.revision),
          current};
}

}  // namespace waymark::session
