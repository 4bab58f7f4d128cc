// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "session/state/room.h"

namespace waymark::session {

/// Who may move and delete an anchor.
enum class AnchorRights : std::uint8_t { kEveryone, kOwner };

struct AnchorRules {
  AnchorRights rights = AnchorRights::kEveryone;
  std::size_t max_anchors = 200'000;    ///< of a room; and private ones of all its owners
  std::size_t max_own_anchors = 1'000;  ///< private ones of an owner in a room
  std::uint64_t live_epoch = 1;
};

/// Answered without the store.
struct CommandVerdict {
  CommandOutcome outcome = CommandOutcome::kApplied;
  std::string reason;
  std::optional<RoomAnchor> current;
};

/// What the store shall be asked.
struct IntendedWrite {
  content::AnchorRecord record;
  std::uint64_t expected_revision = 0;
};

/// Whether all in the room are told of it; else the devices of its owner alone.
bool IsForTheRoom(const content::AnchorRecord& record);

/// Decides a command of a member against the room as acknowledged so far, as far as the member may
/// see it. The store has the last word: another command may be under way.
std::variant<CommandVerdict, IntendedWrite> DecideCommand(const AnchorCommand& command,
                                                          const RoomMember& member,
                                                          const Room& room,
                                                          const AnchorRules& rules);

/// How a conflict that the store found is told. A repetition whose first run was acknowledged
/// before the server restarted finds its own work: that is no conflict. What another owner alone
/// may see is answered as if it had been deleted, for then its id could not be used either.
CommandVerdict DecideConflict(AnchorOperation operation, const content::AnchorRecord& intended,
                              const std::optional<RoomAnchor>& current);

}  // namespace waymark::session
