// SPDX-License-Identifier: Apache-2.0
// Changes of anchors on their way: begun by the application, sent and ended by the worker.
#include "session/device/internal/live_session.h"

namespace waymark::session::internal {
namespace {

constexpr std::size_t kMaxEdits = 1000;  // under way at a time

}  // namespace

Result<void> LiveSession::Begin(const AnchorCommand& command, EditDesk::Ending ending) {
  if (!standing_.is_in) return NotIn();
  if (edits_.Count() >= kMaxEdits) {
    return MakeError(ErrorCode::kUnavailable, "anchor {}: {} changes are under way already",
                     command.anchor.text(), kMaxEdits);
  }
  edits_.Add(command, standing_.owner, ending);
  ++changes_;
  inbox_.Push(WakeUp{});
  return {};
}

Result<CommandReply> LiveSession::Await(const AnchorCommand& command,
                                        std::unique_lock<std::mutex>& lock) {
  WAYMARK_TRY(Begin(command, EditDesk::Ending::kAwaited));
  std::optional<Result<CommandReply>> reply;
  changed_.wait(lock, [&] {
    reply = edits_.TakeReply(command.request);
    return reply || has_left_;
  });
  if (reply) return *std::move(reply);
  return MakeError(ErrorCode::kUnavailable, "anchor {}: left the room before an answer came",
                   command.anchor.text());
}

void LiveSession::SendEdits(Instant now) {
  for (const Uuid& request : edits_.FindOverdue(now)) FinishEdit(request, true);
  const auto patience = std::chrono::duration_cast<Instant::duration>(options_.request_timeout);
  for (const AnchorCommand& command : edits_.TakeReady(now + patience)) {
    commands_.Add(command, now);
  }
}

void LiveSession::FinishEdit(const Uuid& request, bool is_overdue) {
  const AnchorCommand* const command = edits_.Find(request);
  if (command == nullptr) return;
  std::optional<CommandReply> reply;
  if (const auto* const found = commands_.FindReply(request)) reply = *found;
  if (!reply && !is_overdue) return;  // "unavailable" may pass
  const CommandDesk::Farewell farewell = commands_.Remove(request);
  ++changes_;
  if (!reply) {
    const std::string why = farewell.last_refusal.empty() ? "" : ": " + farewell.last_refusal;
    return edits_.Finish(
        request,
        MakeError(ErrorCode::kUnavailable, "{}: no answer about anchor {} within {} s{}",
                  ServerName(), command->anchor.text(), options_.request_timeout.count(), why));
  }
  const bool is_deletion = command->operation == AnchorOperation::kDelete;
  // It was gone when the repetition came: the first one did it.
  const bool is_own_deletion =
      is_deletion && reply->outcome == CommandOutcome::kNotFound && farewell.sent > 1;
  if (is_own_deletion) reply->outcome = CommandOutcome::kApplied;
  if (reply->outcome != CommandOutcome::kApplied) return edits_.Finish(request, ToError(*reply));
  if (is_deletion) view_.OnGone(command->anchor);
  edits_.Finish(request, *reply);
}

void LiveSession::FinishEdits(const Error& error) {
  for (const Uuid& request : edits_.FinishAll(error)) commands_.Remove(request);
}

}  // namespace waymark::session::internal
