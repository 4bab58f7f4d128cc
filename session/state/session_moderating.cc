// SPDX-License-Identifier: Apache-2.0
// What moderators decide: in force at once, and answered when it outlives the server.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "session/state/session_state.h"

namespace waymark::session {

void SessionState::On(const event::RoomCommandReceived& event, Step& step) {
  const RoomCommand& command = event.command;
  RoomMember* const member = FindHeard(command.ticket, step.now);
  if (member == nullptr || member->under_way.contains(command.request)) return;
  if (const CommandReply* const answer = member->FindAnswer(command.request)) {
    step.effects.push_back(effect::SendReply{*answer});
    return;
  }
  std::optional<CommandVerdict> refusal;
  if (member->under_way.size() >= options_.max_writes_per_device) {
    refusal = {CommandOutcome::kUnavailable, "too many commands of this device wait already",
               std::nullopt};
  } else {
    refusal = Moderate(command, *member, step);
  }
  if (refusal) return Answer(*member, command.request, AnchorId(FormatUuid({})), *refusal, step);
  member->under_way.insert(command.request);
  decisions_.push_back({++rules_version_, member->device, command.request});
  if (!rules_being_kept_) KeepRules(step);
}

/// Nothing: it is done.
std::optional<CommandVerdict> SessionState::Moderate(const RoomCommand& command,
                                                     const RoomMember& member, Step& step) {
  const std::string& room = member.room.text();
  if (!MayModerate(member.role())) {
    return CommandVerdict{CommandOutcome::kForbidden,
                          fmt::format("room {}: only a moderator may do that, this device is a {}",
                                      room, RoleName(member.role())),
                          std::nullopt};
  }
  switch (command.operation) {
    case RoomOperation::kRemoveDevice:
      return RemoveByModerator(command, member, step);
    case RoomOperation::kReadmitDevice:
      if (rules_.bans.erase({member.room, command.device}) > 0) return std::nullopt;
      return CommandVerdict{
          CommandOutcome::kNotFound,
          fmt::format("device {}: is not kept out of room {}", command.device.text(), room),
          std::nullopt};
    case RoomOperation::kSetCapacity:
      break;
  }
  return SetCapacity(command, member.room);
}

std::optional<CommandVerdict> SessionState::SetCapacity(const RoomCommand& command,
                                                        const RoomId& room) {
  if (command.capacity < 1 || command.capacity > options_.max_members) {
    return CommandVerdict{CommandOutcome::kInvalid,
                          fmt::format("room {}: expected a capacity in [1, {}], found {}",
                                      room.text(), options_.max_members, command.capacity),
                          std::nullopt};
  }
  if (command.capacity == options_.max_members) {
    rules_.capacities.erase(room);
    return std::nullopt;
  }
  if (!rules_.capacities.contains(room) && rules_.capacities.size() >= options_.max_rules) {
    return CommandVerdict{
        CommandOutcome::kUnavailable,
        fmt::format("{} rooms have a capacity of their own already", options_.max_rules),
        std::nullopt};
  }
  rules_.capacities[room] = command.capacity;
  return std::nullopt;
}

std::uint32_t SessionState::CapacityOf(const RoomId& room) const {
  const auto most = static_cast<std::uint32_t>(options_.max_members);
  const auto set = rules_.capacities.find(room);
  return set == rules_.capacities.end() ? most : std::min(set->second, most);
}

std::optional<CommandVerdict> SessionState::RemoveByModerator(const RoomCommand& command,
                                                              const RoomMember& moderator,
                                                              Step& step) {
  const RoomMember* const target = FindKnown(command.device);
  if (target == nullptr || target->room != moderator.room) {
    // A repetition after a failure to keep it.
    if (rules_.bans.contains({moderator.room, command.device})) return std::nullopt;
    return CommandVerdict{
        CommandOutcome::kNotFound,
        fmt::format("device {}: is not in room {}", command.device.text(), moderator.room.text()),
        std::nullopt};
  }
  if (target->device == moderator.device) {
    return CommandVerdict{CommandOutcome::kInvalid, "a moderator leaves, it does not remove itself",
                          std::nullopt};
  }
  auto& bans = rules_.bans;
  if (bans.size() >= options_.max_rules) {  // the one that ends first makes way
    bans.erase(std::min_element(bans.begin(), bans.end(), [](const auto& a, const auto& b) {
      return a.second.until < b.second.until;
    }));
  }
  bans.insert_or_assign({target->room, target->device}, Ban{.until = step.now + options_.ban,
                                                            .token_id = target->permit.token_id,
                                                            .reason = command.reason});
  SendAway(DeviceId(command.device),
           "removed by a moderator" + (command.reason.empty() ? "" : ": " + command.reason), step);
  return std::nullopt;
}

void SessionState::KeepRules(Step& step) {
  rules_being_kept_ = rules_version_;
  step.effects.push_back(effect::KeepRules{rules_version_, rules_});
}

void SessionState::On(const event::RulesFound& event, Step& step) {
  rules_ = event.rules;
  // The clock that these times were kept in may have been set since.
  for (auto& [whom, ban] : rules_.bans) ban.until = std::min(ban.until, step.now + options_.ban);
  std::erase_if(rules_.bans, [&](const auto& ban) { return ban.second.until <= step.now; });
}

void SessionState::On(const event::RulesKept& event, Step& step) {
  if (rules_being_kept_ != event.version) return;
  rules_being_kept_.reset();
  CommandVerdict verdict;
  if (!event.failure.empty()) {
    verdict = {CommandOutcome::kUnavailable,
               "holds until the server ends and no longer: " + event.failure, std::nullopt};
  }
  for (const PendingDecision& decision : decisions_) {
    RoomMember* const member =
        decision.version <= event.version ? FindKnown(decision.moderator) : nullptr;
    if (member == nullptr || member->under_way.erase(decision.request) == 0) continue;
    Answer(*member, decision.request, AnchorId(FormatUuid({})), verdict, step);
  }
  std::erase_if(decisions_,
                [&](const PendingDecision& decision) { return decision.version <= event.version; });
  if (rules_version_ > event.version) KeepRules(step);
}

}  // namespace waymark::session
