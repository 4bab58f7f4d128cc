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

AnchorCommand ToDelete(const SharedAnchor& anchor) {
  return {.request = MakeUuid(),
          .operation = AnchorOperation::kDelete,
          .anchor = anchor.id,
          .expected_revision = anchor.revision,
          .epoch = anchor.epoch};
}

}  // namespace

Result<AnchorCommand> LiveSession::ToPlace(const Transform<Device, Anchor>& device_from_anchor,
                                           const std::string& kind, const std::string& payload,
                                           content::AnchorVisibility audience) const {
  WAYMARK_TRY(CheckContent(kind, payload));
  const DevicePose pose = CurrentPose();
  if (!pose.map_from_device) {
    return MakeError(ErrorCode::kUnavailable,
                     "anchor: this device has not been localised yet, so it has no place");
  }
  return AnchorCommand{.request = MakeUuid(),
                       .operation = AnchorOperation::kCreate,
                       .anchor = AnchorId(FormatUuid(MakeUuid())),
                       .epoch = pose.epoch,
                       .map_from_anchor = *pose.map_from_device * device_from_anchor,
                       .seen_in = tracker_.SeenIn(),
                       .kind = kind,
                       .payload = payload,
                       .visibility = audience};
}

AnchorCommand LiveSession::ToMove(const SharedAnchor& anchor,
                                  const Transform<Map, Anchor>& map_from_anchor) const {
  return {.request = MakeUuid(),
          .operation = AnchorOperation::kMove,
          .anchor = anchor.id,
          .expected_revision = anchor.revision,
          .epoch = anchor.epoch,
          .map_from_anchor = map_from_anchor,
          .seen_in = tracker_.SeenIn()};
}

// ---- waiting ----------------------------------------------------------------------------------

Result<SharedAnchor> LiveSession::PlaceAnchor(const Transform<Device, Anchor>& device_from_anchor,
                                              const std::string& kind, const std::string& payload,
                                              content::AnchorVisibility audience) {
  std::unique_lock lock(mutex_);
  WAYMARK_TRY_ASSIGN(const AnchorCommand command,
                     ToPlace(device_from_anchor, kind, payload, audience));
  WAYMARK_TRY_ASSIGN(const CommandReply reply, Await(command, lock));
  if (reply.current) return ToShared(*reply.current);
  return MakeError(ErrorCode::kNotFound, "anchor {}: was placed and deleted since",
                   command.anchor.text());
}

Result<SharedAnchor> LiveSession::MoveAnchor(const SharedAnchor& anchor,
                                             const Transform<Map, Anchor>& map_from_anchor) {
  std::unique_lock lock(mutex_);
  WAYMARK_TRY_ASSIGN(const CommandReply reply, Await(ToMove(anchor, map_from_anchor), lock));
  if (reply.current) return ToShared(*reply.current);
  return MakeError(ErrorCode::kNotFound, "anchor {}: was moved and deleted since",
                   anchor.id.text());
}

Result<void> LiveSession::DeleteAnchor(const SharedAnchor& anchor) {
  std::unique_lock lock(mutex_);
  WAYMARK_TRY(Await(ToDelete(anchor), lock));
  return {};
}

// ---- not waiting ------------------------------------------------------------------------------

Result<SharedAnchor> LiveSession::BeginPlace(const Transform<Device, Anchor>& device_from_anchor,
                                             const std::string& kind, const std::string& payload,
                                             content::AnchorVisibility audience) {
  const std::lock_guard lock(mutex_);
  WAYMARK_TRY_ASSIGN(const AnchorCommand command,
                     ToPlace(device_from_anchor, kind, payload, audience));
  WAYMARK_TRY(Begin(command, EditDesk::Ending::kTold));
  return *edits_.Show(command.anchor, std::nullopt);
}

Result<void> LiveSession::BeginMove(const SharedAnchor& anchor,
                                    const Transform<Map, Anchor>& map_from_anchor) {
  const std::lock_guard lock(mutex_);
  return Begin(ToMove(anchor, map_from_anchor), EditDesk::Ending::kTold);
}

Result<void> LiveSession::BeginDelete(const SharedAnchor& anchor) {
  const std::lock_guard lock(mutex_);
  return Begin(ToDelete(anchor), EditDesk::Ending::kTold);
}

std::vector<EditOutcome> LiveSession::TakeOutcomes() {
  const std::lock_guard lock(mutex_);
  return edits_.TakeOutcomes();
}

// ---- what is there ----------------------------------------------------------------------------

std::vector<SharedAnchor> LiveSession::Anchors() const {
  const std::lock_guard lock(mutex_);
  return edits_.Show(view_.Anchors());
}

std::optional<SharedAnchor> LiveSession::FindAnchor(const AnchorId& anchor) const {
  const std::lock_guard lock(mutex_);
  return edits_.Show(anchor, view_.FindAnchor(anchor));
}

bool LiveSession::HasSnapshot() const {
  const std::lock_guard lock(mutex_);
  return view_.HasSnapshot();
}

}  // namespace waymark::session::internal
