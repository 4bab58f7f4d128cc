// SPDX-License-Identifier: Apache-2.0
#include "session/device/c/held.h"
#include "session/device/c/values.h"

namespace waymark::session::c {
namespace {

constexpr std::size_t kMaxPayloadBytes = 64 * 1024;

Result<std::string> ReadPayload(const WaymarkPlacement& placement) {
  if (placement.payload_bytes == 0) return std::string();
  WAYMARK_TRY(Need(placement.payload, "placement's payload"));
  if (placement.payload_bytes > kMaxPayloadBytes) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "placement's payload: expected at most {} bytes, found {}", kMaxPayloadBytes,
                     placement.payload_bytes);
  }
  return std::string(static_cast<const char*>(placement.payload), placement.payload_bytes);
}

/// Where what stands after a change goes, if the app wants to know.
class Now {
 public:
  static Result<Now> Of(WaymarkAnchor* theirs) {
    Now now;
    now.theirs_ = theirs;
    if (theirs == nullptr) return now;
    WAYMARK_TRY_ASSIGN(now.size_, ReadStructSize(theirs, kFirstSize<WaymarkAnchor>, "now"));
    return now;
  }

  void Is(const std::optional<SharedAnchor>& anchor) const {
    if (theirs_ != nullptr) FillStruct(anchor ? ToC(*anchor) : WaymarkAnchor{}, size_, theirs_);
  }

  /// Also with a conflict, what stands is known.
  Outcome After(const Result<SharedAnchor>& change, const DeviceSession& device,
                const AnchorId& id) const {
    if (change.ok()) {
      Is(*change);
      return {};
    }
    if (change.error().code == ErrorCode::kConflict) Is(device.FindAnchor(id));
    return change.error();
  }

 private:
  WaymarkAnchor* theirs_ = nullptr;
  std::size_t size_ = 0;
};

Result<SharedAnchor> FindAnchor(const DeviceSession& device, const char* anchor) {
  WAYMARK_TRY_ASSIGN(const std::string id, ReadText(anchor, WAYMARK_ID_BYTES - 1, "anchor"));
  if (auto found = device.FindAnchor(AnchorId(id))) return *std::move(found);
  return MakeError(ErrorCode::kNotFound, "anchor \"{}\": is not in the room", id);
}

using Placing = Result<SharedAnchor> (DeviceSession::*)(const Transform<Device, Anchor>&,
                                                        const std::string&, const std::string&,
                                                        content::AnchorVisibility);

WaymarkStatus Place(WaymarkSession session, const WaymarkPlacement* placement, WaymarkAnchor* now,
                    Placing place) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY_ASSIGN(const WaymarkPlacement theirs, ReadStruct(placement, "placement"));
    WAYMARK_TRY_ASSIGN(const auto where, (ReadTransform<Device, Anchor>(&theirs.device_from_anchor,
                                                                        "device_from_anchor")));
    WAYMARK_TRY_ASSIGN(const auto kind,
                       ReadText(theirs.kind, WAYMARK_TEXT_BYTES - 1, "placement's kind"));
    WAYMARK_TRY_ASSIGN(const auto payload, ReadPayload(theirs));
    WAYMARK_TRY_ASSIGN(const Now answer, Now::Of(now));
    WAYMARK_TRY_ASSIGN(const auto audience, ReadAudience(theirs.audience));
    const auto placed = (device.*place)(where, kind, payload, audience);
    if (!placed) return placed.error();
    answer.Is(*placed);
    return {};
  });
}

}  // namespace
}  // namespace waymark::session::c

using namespace waymark::session::c;  // NOLINT: the functions below are C's
using waymark::session::DeviceSession;
using waymark::session::SharedAnchor;

WaymarkStatus waymark_place_anchor(WaymarkSession session, const WaymarkPlacement* placement,
                                   WaymarkAnchor* now) {
  return Place(session, placement, now, &DeviceSession::PlaceAnchor);
}

WaymarkStatus waymark_begin_place_anchor(WaymarkSession session, const WaymarkPlacement* placement,
                                         WaymarkAnchor* now) {
  return Place(session, placement, now, &DeviceSession::BeginPlace);
}

WaymarkStatus waymark_begin_move_anchor(WaymarkSession session, const WaymarkAnchor* held,
                                        const WaymarkTransform* map_from_anchor) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY_ASSIGN(const SharedAnchor anchor, ReadAnchor(held));
    WAYMARK_TRY_ASSIGN(const auto place, (ReadTransform<waymark::Map, waymark::Anchor>(
                                             map_from_anchor, "map_from_anchor")));
    return device.BeginMove(anchor, place);
  });
}

WaymarkStatus waymark_begin_delete_anchor(WaymarkSession session, const WaymarkAnchor* held) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY_ASSIGN(const SharedAnchor anchor, ReadAnchor(held));
    return device.BeginDelete(anchor);
  });
}

WaymarkStatus waymark_move_anchor(WaymarkSession session, const WaymarkAnchor* held,
                                  const WaymarkTransform* map_from_anchor, WaymarkAnchor* now) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY_ASSIGN(const SharedAnchor anchor, ReadAnchor(held));
    WAYMARK_TRY_ASSIGN(const auto place, (ReadTransform<waymark::Map, waymark::Anchor>(
                                             map_from_anchor, "map_from_anchor")));
    WAYMARK_TRY_ASSIGN(const Now answer, Now::Of(now));
    return answer.After(device.MoveAnchor(anchor, place), device, anchor.id);
  });
}

WaymarkStatus waymark_delete_anchor(WaymarkSession session, const WaymarkAnchor* held,
                                    WaymarkAnchor* now) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY_ASSIGN(const SharedAnchor anchor, ReadAnchor(held));
    WAYMARK_TRY_ASSIGN(const Now answer, Now::Of(now));
    const auto deleted = device.DeleteAnchor(anchor);
    if (!deleted) return answer.After(deleted.error(), device, anchor.id);
    answer.Is(std::nullopt);
    return {};
  });
}

WaymarkStatus waymark_find_anchor(WaymarkSession session, const char* anchor,
                                  WaymarkAnchor* found) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY_ASSIGN(const SharedAnchor ours, FindAnchor(device, anchor));
    return WriteStruct(ToC(ours), found, "found");
  });
}

WaymarkStatus waymark_anchors(WaymarkSession session, WaymarkAnchor* anchors, size_t capacity,
                              size_t* count) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    return WriteArray(device.Anchors(), anchors, capacity, count, "anchors",
                      [](const auto& anchor) { return ToC(anchor); });
  });
}

WaymarkStatus waymark_anchor_payload(WaymarkSession session, const char* anchor, void* payload,
                                     size_t capacity, size_t* payload_bytes) {
  return WithDevice(session, [&](DeviceSession& device) -> Outcome {
    WAYMARK_TRY(Need(payload_bytes, "payload_bytes"));
    WAYMARK_TRY_ASSIGN(const SharedAnchor ours, FindAnchor(device, anchor));
    const std::size_t size = ours.payload.size();
    *payload_bytes = size;
    if (size > capacity) {
      return {WAYMARK_TOO_SMALL,
              fmt::format("payload: has {} bytes, room is for {}", size, capacity)};
    }
    if (size == 0) return {};
    WAYMARK_TRY(Need(payload, "payload"));
    std::memcpy(payload, ours.payload.data(), size);
    return {};
  });
}
