// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "session/device/internal/desks.h"

namespace waymark::session::internal {

/// Changes of anchors that are shown before they are durable. Of each anchor one is under way at a
/// time, the next on top of what that brought about; when one fails, those on top of it fail too.
/// Pure: the caller tells it the time of its steady clock. Thread-compatible.
class EditDesk {
 public:
  /// Keeps its outcome for TakeOutcomes, or, if somebody waits for it, for TakeReply.
  enum class Ending { kTold, kAwaited };

  /// `owner` of what it places. A move that nobody waits for takes the place of one that has not
  /// been sent.
  void Add(const AnchorCommand& command, const std::string& owner, Ending ending);
  /// Those whose turn it is now, with what they stand on; they fail at `deadline`.
  std::vector<AnchorCommand> TakeReady(Instant deadline);
  std::vector<Uuid> FindOverdue(Instant now) const;
  Instant NextDeadline() const;
  std::size_t Count() const;

  /// The one under way, nothing for requests of others.
  const AnchorCommand* Find(const Uuid& request) const;
  void Finish(const Uuid& request, const Result<CommandReply>& reply);
  /// Of those that were under way, the requests.
  std::vector<Uuid> FinishAll(const Error& error);
  std::optional<Result<CommandReply>> TakeReply(const Uuid& request);
  std::vector<EditOutcome> TakeOutcomes();

  /// The map's frame is another one: what this phone placed moves with this phone.
  void CarryBy(const Transform<Map, Map>& motion, std::uint64_t epoch);
  /// With what is not durable yet.
  std::vector<SharedAnchor> Show(std::vector<SharedAnchor> anchors) const;
  std::optional<SharedAnchor> Show(const AnchorId& anchor, std::optional<SharedAnchor> known) const;

 private:
  struct Edit {
    AnchorCommand command;
    std::string owner;
    Ending ending;
    std::optional<Instant> deadline;  // once it is under way
  };
  void End(const Edit& edit, const Result<CommandReply>& reply);

  std::map<AnchorId, std::deque<Edit>> edits_;
  std::map<Uuid, Result<CommandReply>> replies_;
  std::vector<EditOutcome> outcomes_;
};

}  // namespace waymark::session::internal
