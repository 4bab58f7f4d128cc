// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "content_store/anchor_record.h"
#include "mapping/base/id.h"
#include "mapping/geometry/frames.h"
#include "session/state/poses.h"
#include "session/state/uuid.h"

/// What devices and the server say to each other of anchors.
namespace waymark::session {

struct RoomAnchor {
  content::AnchorRecord record;
  bool is_supported = true;  ///< false: none of its submaps is left in the map
};

struct AnchorState {
  RunId run{};
  RoomAnchor anchor;  ///< room, place and times do not travel
};

enum class AnchorOperation : std::uint8_t { kCreate, kMove, kDelete };

struct AnchorCommand {
  Ticket ticket{};
  Uuid request{};  ///< the same in every repetition
  AnchorOperation operation = AnchorOperation::kCreate;
  AnchorId anchor;
  std::uint64_t expected_revision = 0;  ///< move, delete
  std::uint64_t epoch = 1;              ///< of map_from_anchor
  Transform<Map, Anchor> map_from_anchor = {};
  std::vector<SubmapId> seen_in = {};  ///< submaps of the fixes it stands on, best first
  std::string kind = {};               ///< create
  std::string payload = {};            ///< create
  content::AnchorVisibility visibility = content::AnchorVisibility::kRoom;  ///< create
};

enum class CommandOutcome : std::uint8_t {
  kApplied,
  kConflict,
  kNotFound,
  kInvalid,
  kUnavailable,
  kForbidden,  ///< not with this role
};

struct CommandReply {
  DeviceId device;
  Uuid request{};
  CommandOutcome outcome = CommandOutcome::kApplied;
  std::string reason = {};
  AnchorId anchor;
  std::optional<RoomAnchor> current = {};  ///< what stands there now; absent: nothing
};

struct RoomState {
  RoomId room;
  RunId run{};
  std::uint64_t revision = 0;
  std::uint64_t epoch = 1;
  std::uint32_t anchor_count = 0;
  std::uint64_t anchor_digest = 0;  ///< XOR of AnchorDigest over the anchors

  friend bool operator==(const RoomState&, const RoomState&) = default;
};

/// Of an owner's private anchors in a room, told to its devices alone.
struct OwnerState {
  std::string owner;
  RunId run{};
  std::uint32_t anchor_count = 0;
  std::uint64_t anchor_digest = 0;
};

/// What an anchor in this state adds to the digest of its room or owner.
std::uint64_t AnchorDigest(const AnchorId& anchor, std::uint64_t revision);

// ---- the anchors of an area -------------------------------------------------------------------

/// Which anchors of its room a device is told of; its owner's private ones it is told in any case.
enum class AnchorScope : std::uint8_t { kRoom, kArea };

/// A circle on the ground of the map, without its edge.
struct AnchorArea {
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  double radius_m = 0;

  bool Holds(const Eigen::Vector3d& position_in_map) const {
    return (position_in_map.head<2>() - centre_m).squaredNorm() < radius_m * radius_m;
  }
};
inline constexpr double kMaxAreaRadius_m = 2000;
/// A device that asks more often is not heard; it repeats what has no answer.
inline constexpr std::chrono::milliseconds kMinAreaInterval{100};

/// What a device is interested in from now on. Repeated until an AreaState has its number.
struct AreaReport {
  Ticket ticket{};
  std::uint32_t number = 0;  ///< grows with each area of the device
  AnchorArea area = {};
  bool is_anew = false;  ///< whatever it was told before counts no more
};

/// What a device is told of its area.
struct AreaState {
  DeviceId device;
  RunId run{};
  std::uint32_t number = 0;         ///< of the report
  AnchorArea area = {};             ///< smaller than asked for where there are too many
  std::uint32_t anchor_count = 0;   ///< in it
  std::uint64_t anchor_digest = 0;  ///< XOR of AnchorDigest over them
};

}  // namespace waymark::session
