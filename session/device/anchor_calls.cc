// SPDX-License-Identifier: Apache-2.0
// The application's half of a device session: anchors.
#include "session/device/internal/live_session.h"

namespace waymark::session::internal {
namespace {

Result<void> CheckContent(const std::string& kind, const std::string& payload) {
  if (kind.size() > kMaxKindBytes) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "anchor kind: expected at most {} bytes, found {}", kMaxKindBytes,
                     kind.size());
  }
  if (payload.size() > kMaxPayloadBytes) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "anchor payload: expected at most {} bytes, found {}", kMaxPayloadBytes,
                     payload.size());
  }
  return {};
}

/// An earlier server would show to the whole room what is for its owner alone.
Result<void> CheckAudience(content::AnchorVisibility audience,
                           const std::optional<Welcome>& welcome) {
  if (audience == content::AnchorVisibility::kRoom) return {};
  if (!welcome) return MakeError(ErrorCode::kUnavailable, "anchor: no server has answered yet");
  if (welcome->protocol >= kAudienceProtocol) return {};
  return MakeError(ErrorCode::kUnsupported,
                   "anchor: the server is of a version whose anchors are all the room's");
}

}  // namespace

Result<CommandReply> LiveSession::Perform(AnchorCommand command) {
  command.request = MakeUuid();
  int sent = 0;
  WAYMARK_TRY_ASSIGN(CommandReply reply, Await(command, "anchor " + command.anchor.text(), sent));
  // It was gone when the repetition came: the first one did it.
  const bool is_own_deletion = command.operation == AnchorOperation::kDelete &&
                               reply.outcome == CommandOutcome::kNotFound && sent > 1;
  if (is_own_deletion) reply.outcome = CommandOutcome::kApplied;
  if (reply.outcome != CommandOutcome::kApplied) return ToError(reply);
  return reply;
}

Result<SharedAnchor> LiveSession::PlaceAnchor(const Transform<Device, Anchor>& device_from_anchor,
                                              const std::string& kind, const std::string& payload,
                                              content::AnchorVisibility audience) {
  WAYMARK_TRY(CheckContent(kind, payload));
  AnchorCommand command{.operation = AnchorOperation::kCreate,
                        .anchor = AnchorId(FormatUuid(MakeUuid())),
                        .kind = kind,
                        .payload = payload,
                        .visibility = audience};
  {
    const std::lock_guard lock(mutex_);
    WAYMARK_TRY(CheckAudience(audience, join_.welcome()));
    const DevicePose pose = CurrentPose();
    if (!pose.map_from_device) {
      return MakeError(ErrorCode::kUnavailable,
                       "anchor: this device has not been localised yet, so it has no place");
    }
    command.map_from_anchor = *pose.map_from_device * device_from_anchor;
    command.epoch = pose.epoch;
    command.seen_in = tracker_.SeenIn();
  }
  WAYMARK_TRY_ASSIGN(const CommandReply reply, Perform(command));
  if (reply.current) return ToShared(*reply.current);
  return MakeError(ErrorCode::kNotFound, "anchor {}: was placed and deleted since",
                   command.anchor.text());
}

Result<SharedAnchor> LiveSession::MoveAnchor(const SharedAnchor& anchor,
                                             const Transform<Map, Anchor>& map_from_anchor) {
  AnchorCommand command{.operation = AnchorOperation::kMove,
                        .anchor = anchor.id,
                        .expected_revision = anchor.revision,
                        .epoch = anchor.epoch,
                        .map_from_anchor = map_from_anchor};
  {
    const std::lock_guard lock(mutex_);
    command.seen_in = tracker_.SeenIn();
  }
  WAYMARK_TRY_ASSIGN(const CommandReply reply, Perform(command));
  if (reply.current) return ToShared(*reply.current);
  return MakeError(ErrorCode::kNotFound, "anchor {}: was moved and deleted since",
                   anchor.id.text());
}

Result<void> LiveSession::DeleteAnchor(const SharedAnchor& anchor) {
  WAYMARK_TRY_ASSIGN(const CommandReply reply,
                     Perform(AnchorCommand{.operation = AnchorOperation::kDelete,
                                           .anchor = anchor.id,
                                           .expected_revision = anchor.revision,
                                           .epoch = anchor.epoch}));
  const std::lock_guard lock(mutex_);
  view_.OnGone(anchor.id);
  ++changes_;
  return {};
}

std::vector<SharedAnchor> LiveSession::Anchors() const {
  const std::lock_guard lock(mutex_);
  return view_.Anchors();
}

std::optional<SharedAnchor> LiveSession::FindAnchor(const AnchorId& anchor) const {
  const std::lock_guard lock(mutex_);
  return view_.FindAnchor(anchor);
}

bool LiveSession::HasSnapshot() const {
  const std::lock_guard lock(mutex_);
  return view_.HasSnapshot();
}

}  // namespace waymark::session::internal
