// SPDX-License-Identifier: Apache-2.0
// The application's half of a device session: what it commands, and a moderator's commands.
#include <algorithm>
#include <random>

#include "session/device/internal/live_session.h"

namespace waymark::session::internal {

Uuid MakeUuid() {
  std::random_device device;
  const auto bits = [&device] { return std::uint64_t{device()} << 32 | device(); };
  return UuidFromBits(bits(), bits());
}

Error ToError(const CommandReply& reply) {
  const auto code = [&] {
    switch (reply.outcome) {
      case CommandOutcome::kConflict:
        return ErrorCode::kConflict;
      case CommandOutcome::kNotFound:
        return ErrorCode::kNotFound;
      case CommandOutcome::kInvalid:
      case CommandOutcome::kForbidden:
        return ErrorCode::kInvalidArgument;
      case CommandOutcome::kApplied:
      case CommandOutcome::kUnavailable:
        break;
    }
    return ErrorCode::kUnavailable;
  };
  return Error{code(), reply.reason};
}

Result<CommandReply> LiveSession::Await(const Command& command, const std::string& about,
                                        int& sent) {
  const Uuid request = std::visit([](const auto& any) { return any.request; }, command);
  std::unique_lock lock(mutex_);
  if (!standing_.is_in) return NotIn();
  commands_.Add(command, std::chrono::steady_clock::now());
  inbox_.Push(WakeUp{});
  changed_.wait_for(lock, options_.request_timeout, [&] {
    return has_left_ || !standing_.is_in || commands_.FindReply(request) != nullptr;
  });
  std::optional<CommandReply> reply;
  if (const auto* found = commands_.FindReply(request)) reply = *found;
  const CommandDesk::Farewell farewell = commands_.Remove(request);
  sent = farewell.sent;
  if (!reply && !standing_.is_in) return NotIn();
  if (!reply) {
    const std::string why = farewell.last_refusal.empty() ? "" : ": " + farewell.last_refusal;
    return MakeError(ErrorCode::kUnavailable, "{}: no answer about {} within {} s{}", ServerName(),
                     about, options_.request_timeout.count(), why);
  }
  return *std::move(reply);
}

Result<void> LiveSession::Perform(RoomCommand command) {
  command.request = MakeUuid();
  int sent = 0;
  WAYMARK_TRY_ASSIGN(const CommandReply reply,
                     Await(command, "room " + options_.room.text(), sent));
  // Not there when the repetition came: the first one did it.
  const bool is_done = reply.outcome == CommandOutcome::kApplied ||
                       (reply.outcome == CommandOutcome::kNotFound && sent > 1);
  if (!is_done) return ToError(reply);
  return {};
}

Result<void> LiveSession::Kick(const DeviceId& device, const std::string& reason) {
  return Perform(
      RoomCommand{.operation = RoomOperation::kRemoveDevice, .device = device, .reason = reason});
}

Result<void> LiveSession::Readmit(const DeviceId& device) {
  return Perform(RoomCommand{.operation = RoomOperation::kReadmitDevice, .device = device});
}

Result<void> LiveSession::SetCapacity(int devices) {
  return Perform(RoomCommand{.operation = RoomOperation::kSetCapacity,
                             .capacity = static_cast<std::uint32_t>(std::max(devices, 0))});
}

}  // namespace waymark::session::internal
