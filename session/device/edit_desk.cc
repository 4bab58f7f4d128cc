// SPDX-License-Identifier: Apache-2.0
#include "session/device/internal/edit_desk.h"

#include <algorithm>
#include <utility>

namespace waymark::session::internal {
namespace {

constexpr std::size_t kMaxOutcomes = 10'000;  // of an app that never asks

SharedAnchor ToShown(const AnchorCommand& command, const std::string& owner) {
  return {.id = command.anchor,
          .owner = DeviceId(owner),
          .map_from_anchor = command.map_from_anchor,
          .epoch = command.epoch,
          .kind = command.kind,
          .payload = command.payload,
          .audience = command.visibility,
          .is_pending = true};
}

}  // namespace

void EditDesk::Add(const AnchorCommand& command, const std::string& owner, Ending ending) {
  std::deque<Edit>& queue = edits_[command.anchor];
  const auto is_passing_move = [](const AnchorCommand& c, Ending e) {
    return c.operation == AnchorOperation::kMove && e == Ending::kTold;
  };
  const bool replaces = is_passing_move(command, ending) && !queue.empty() &&
                        !queue.back().deadline &&
                        is_passing_move(queue.back().command, queue.back().ending);
  if (replaces) queue.pop_back();
  queue.push_back({command, owner, ending, std::nullopt});
}

std::vector<AnchorCommand> EditDesk::TakeReady(Instant deadline) {
  std::vector<AnchorCommand> ready;
  for (auto& [anchor, queue] : edits_) {
    if (queue.front().deadline) continue;
    queue.front().deadline = deadline;
    ready.push_back(queue.front().command);
  }
  return ready;
}

std::vector<Uuid> EditDesk::FindOverdue(Instant now) const {
  std::vector<Uuid> overdue;
  for (const auto& [anchor, queue] : edits_) {
    const Edit& edit = queue.front();
    if (edit.deadline && now >= *edit.deadline) overdue.push_back(edit.command.request);
  }
  return overdue;
}

Instant EditDesk::NextDeadline() const {
  Instant next = kNever;
  for (const auto& [anchor, queue] : edits_) {
    next = std::min(next, queue.front().deadline.value_or(Instant::min()));
  }
  return next;
}

std::size_t EditDesk::Count() const {
  std::size_t count = 0;
  for (const auto& [anchor, queue] : edits_) count += queue.size();
  return count;
}

const AnchorCommand* EditDesk::Find(const Uuid& request) const {
  for (const auto& [anchor, queue] : edits_) {
    if (queue.front().command.request == request) return &queue.front().command;
  }
  return nullptr;
}

void EditDesk::Finish(const Uuid& request, const Result<CommandReply>& reply) {
  const AnchorCommand* const command = Find(request);
  if (command == nullptr) return;
  const auto found = edits_.find(command->anchor);
  std::deque<Edit> queue = std::move(found->second);
  edits_.erase(found);
  End(queue.front(), reply);
  queue.pop_front();
  if (queue.empty()) return;
  if (!reply.ok()) {
    for (const Edit& edit : queue) End(edit, reply.error());
    return;
  }
  if (reply->current) queue.front().command.expected_revision = reply->current->record.revision;
  const AnchorId anchor = queue.front().command.anchor;
  edits_.emplace(anchor, std::move(queue));
}

std::vector<Uuid> EditDesk::FinishAll(const Error& error) {
  std::vector<Uuid> requests;
  for (const auto& [anchor, queue] : std::exchange(edits_, {})) {
    requests.push_back(queue.front().command.request);
    for (const Edit& edit : queue) End(edit, error);
  }
  return requests;
}

void EditDesk::End(const Edit& edit, const Result<CommandReply>& reply) {
  if (edit.ending == Ending::kAwaited) {
    replies_.emplace(edit.command.request, reply);
    return;
  }
  if (outcomes_.size() == kMaxOutcomes) outcomes_.erase(outcomes_.begin());
  outcomes_.push_back({.anchor = edit.command.anchor,
                       .edit = edit.command.operation,
                       .error = reply.ok() ? std::nullopt : std::optional(reply.error())});
}

std::optional<Result<CommandReply>> EditDesk::TakeReply(const Uuid& request) {
  const auto found = replies_.find(request);
  if (found == replies_.end()) return std::nullopt;
  Result<CommandReply> reply = std::move(found->second);
  replies_.erase(found);
  return reply;
}

std::vector<EditOutcome> EditDesk::TakeOutcomes() { return std::exchange(outcomes_, {}); }

void EditDesk::CarryBy(const Transform<Map, Map>& motion, std::uint64_t epoch) {
  for (auto& [anchor, queue] : edits_) {
    for (Edit& edit : queue) {
      edit.command.map_from_anchor = motion * edit.command.map_from_anchor;
      edit.command.epoch = epoch;
    }
  }
}

std::vector<SharedAnchor> EditDesk::Show(std::vector<SharedAnchor> anchors) const {
  if (edits_.empty()) return anchors;
  std::vector<SharedAnchor> shown;
  std::size_t known = 0;
  for (SharedAnchor& anchor : anchors) {
    if (!edits_.contains(anchor.id)) {
      shown.push_back(std::move(anchor));
    } else {
      ++known;
      const AnchorId id = anchor.id;
      if (auto edited = Show(id, std::move(anchor))) shown.push_back(*std::move(edited));
    }
  }
  if (known == edits_.size()) return shown;
  for (const auto& [id, queue] : edits_) {
    if (queue.front().command.operation != AnchorOperation::kCreate) continue;
    const bool is_told = std::ranges::any_of(shown, [&](const auto& a) { return a.id == id; });
    if (is_told) continue;
    if (auto placed = Show(id, std::nullopt)) shown.push_back(*std::move(placed));
  }
  return shown;
}

std::optional<SharedAnchor> EditDesk::Show(const AnchorId& anchor,
                                           std::optional<SharedAnchor> known) const {
  const auto found = edits_.find(anchor);
  if (found == edits_.end()) return known;
  for (const Edit& edit : found->second) {
    const AnchorCommand& command = edit.command;
    if (command.operation == AnchorOperation::kCreate && !known) {
      known = ToShown(command, edit.owner);
    } else if (command.operation == AnchorOperation::kMove && known) {
      known->map_from_anchor = command.map_from_anchor;
      known->epoch = command.epoch;
      known->is_pending = true;
    } else if (command.operation == AnchorOperation::kDelete) {
      known.reset();
    }
  }
  return known;
}

}  // namespace waymark::session::internal
