// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "content_store/anchor_record.h"
#include "localiser/odometry_alignment.h"
#include "mapping/base/id.h"
#include "mapping/base/result.h"
#include "mapping/base/time.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/frames.h"
#include "mapping/geometry/geodesy.h"
#include "session/device/device_options.h"
#include "session/state/anchors.h"
#include "session/state/role.h"

namespace waymark::session {

/// A camera image of the phone, 8-bit luminance.
struct DeviceFrame {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> pixels;
  CameraModel camera;
  Transform<Device, Camera> device_from_camera;
  Transform<Vo, Device> vo_from_device;
  DeviceTime time;
  std::optional<GeoPoint> gnss = std::nullopt;
  double gnss_sigma_m = 10;
  /// Unit, from the phone's gravity; absent: the odometry's z.
  std::optional<Eigen::Vector3d> up_in_camera = std::nullopt;
};

/// Who localised a keyframe.
enum class FixSource : std::uint8_t { kServer, kTile };

/// Where this phone is now.
struct DevicePose {
  localiser::AlignmentState state = localiser::AlignmentState::kNever;
  std::optional<Transform<Map, Device>> map_from_device;  ///< absent while never localised
  /// Of Perturb's delta in the map frame; holds also what of a correction is still to come.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
  std::uint64_t epoch = 0;
  DeviceTime time;
  FixSource fix_source = FixSource::kServer;  ///< of the newest fix
};

/// How sure a phone is of its pose: one standard deviation of the position on each axis, and of the
/// rotation about each.
struct PoseCertainty {
  double sigma_m = 0;
  double rotation_sigma_rad = 0;
};

/// Another phone of the room: where it is now, as far as its last reports tell.
struct OtherDevice {
  DeviceId id;
  std::string name;
  bool is_present = true;
  std::optional<Transform<Map, Device>> map_from_device;
  /// Of the position on each axis, and of the rotation about each; they grow with what may have
  /// happened since the last report.
  double sigma_m = 0;
  double rotation_sigma_rad = 0;
  /// As it said last: how well it knows where it is itself.
  localiser::AlignmentState tracking = localiser::AlignmentState::kNever;
  PoseCertainty certainty = {};
  std::uint64_t epoch = 0;
  std::chrono::duration<double> age{0};  ///< of the last report when asked
  Role role = Role::kMember;
};

/// What this phone is in its room.
struct RoomStanding {
  bool is_in = true;        ///< false: sent away, or not let in again after a silence
  std::string reason = {};  ///< why it is not in
  Role role = Role::kMember;
  std::string owner =
      {};           ///< of what this phone places, see SharedAnchor; empty before the welcome
  int returns = 0;  ///< how often it was away for a while and came back as itself
};

struct SharedAnchor {
  AnchorId id;
  DeviceId owner;  ///< who placed it: a device, or "@…" for all that know its owner's secret
  Transform<Map, Anchor> map_from_anchor;
  std::uint64_t epoch = 0;
  std::uint64_t revision = 0;
  std::string kind;
  std::string payload;
  bool is_supported = true;  ///< false: none of the submaps it was seen in is left in the map
  content::AnchorVisibility audience = content::AnchorVisibility::kRoom;
  bool is_pending = false;  ///< a change of this phone's is shown that is not durable yet
};

/// What became of a change that was begun and not waited for.
struct EditOutcome {
  AnchorId anchor;
  AnchorOperation edit{};
  /// Absent: it is durable. Conflict: somebody else changed the anchor first; FindAnchor has what
  /// stands. Otherwise as of PlaceAnchor, MoveAnchor and DeleteAnchor. What was shown is taken
  /// back.
  std::optional<Error> error = std::nullopt;
};

/// Where the time of a keyframe went that was localised, in milliseconds.
struct KeyframeTiming {
  double total_ms = 0;     ///< image pushed until fix applied
  double encode_ms = 0;    ///< waiting for the worker, and JPEG
  double uplink_ms = 0;    ///< until all of it was at the server
  double queue_ms = 0;     ///< there
  double features_ms = 0;  ///< decoding the JPEG is in server_ms alone
  double search_ms = 0;
  double pose_ms = 0;
  double server_ms = 0;  ///< from all of it there until the answer left; holds the four before
  double downlink_ms = 0;
  std::size_t image_bytes = 0;
  int width_px = 0;
  int images = 1;  ///< that it was found by, see DeviceOptions::burst_images
};

/// Counters for people and tests.
struct DeviceStatistics {
  int keyframes_sent = 0;
  int superseded = 0;   ///< of these, given up for a newer one before they had left
  int fixes = 0;        ///< of the server
  int burst_fixes = 0;  ///< of these, of keyframes that were found together with earlier ones
  int tile_fixes = 0;   ///< the device's own, against its tile
  int tile_refusals = 0;
  int refusals = 0;  ///< the server answered "not localised" or "busy"
  int timeouts = 0;
  int map_changes = 0;  ///< another release of the map went live meanwhile
  int clock_jumps = 0;  ///< of the clock that stamps frames and odometry
  int joins = 0;        ///< 1, and one more for every time the server had to be found again
  std::vector<KeyframeTiming> keyframe_timings;  ///< of the latest hour's fixes
};

/// The map that the room stands in. When another release goes live, pose, anchors and epoch change
/// together between two calls; content keeps its place before the phone.
struct SessionMap {
  std::string id;
  bool is_geo_aligned = true;
  GeoPoint origin;
  std::uint64_t epoch = 0;
};

/// What a phone app links: joins a room and keeps odometry, map, other phones and anchors together.
/// Thread-safe; calls do not block on the network unless they say so. Errors name the server.
class DeviceSession {
 public:
  /// Joins, waiting for the server's welcome at most the request timeout. With a tile, a server
  /// that does not answer is no error: the device begins alone and joins when it does.
  /// Errors: Unavailable (no server there), InvalidArgument, Conflict (room refuses); of the tile.
  static Result<std::unique_ptr<DeviceSession>> Join(const DeviceOptions& options);
  virtual ~DeviceSession() = default;

  virtual const DeviceId& id() const = 0;
  /// Where the map is, as the server last said.
  virtual SessionMap DescribeMap() const = 0;
  /// Hands over a frame; a keyframe is sent when the interval has passed and none is under way.
  virtual Result<void> PushFrame(const DeviceFrame& frame) = 0;
  /// Odometry between frames: cheap, at the rate the phone has it; publishes the live pose.
  virtual void PushOdometry(const Transform<Vo, Device>& vo_from_device, DeviceTime time) = 0;
  virtual DevicePose Pose() const = 0;
  /// What the session's clock showed at an instant of the clock that stamps frames and odometry;
  /// nothing before the first exchange with the server.
  virtual std::optional<ServerTime> SessionTime(DeviceTime instant) const = 0;
  virtual std::vector<OtherDevice> Others() const = 0;

  virtual RoomStanding Standing() const = 0;
  /// For moderators: sends a phone away, which learns the reason and may not come back for a while;
  /// lets it come back; sets how many the room holds. Each waits for the answer.
  /// Errors: InvalidArgument (not a moderator, a bad capacity), NotFound, Unavailable.
  virtual Result<void> Kick(const DeviceId& device, const std::string& reason) = 0;
  virtual Result<void> Readmit(const DeviceId& device) = 0;
  virtual Result<void> SetCapacity(int devices) = 0;

  /// Places content relative to the phone's present pose. Waits for the durable acknowledgement. A
  /// private anchor is told to the phones of its owner in the room and to nobody else.
  /// Errors: Unavailable (never localised, no answer, or sent away), Conflict, InvalidArgument
  /// (which viewers are told too).
  virtual Result<SharedAnchor> PlaceAnchor(const Transform<Device, Anchor>& device_from_anchor,
                                           const std::string& kind, const std::string& payload,
                                           content::AnchorVisibility audience) = 0;
  /// For the whole room.
  Result<SharedAnchor> PlaceAnchor(const Transform<Device, Anchor>& device_from_anchor,
                                   const std::string& kind, const std::string& payload) {
    return PlaceAnchor(device_from_anchor, kind, payload, content::AnchorVisibility::kRoom);
  }
  /// Errors: Conflict when someone else changed it first: FindAnchor has what stands; NotFound.
  virtual Result<SharedAnchor> MoveAnchor(const SharedAnchor& anchor,
                                          const Transform<Map, Anchor>& map_from_anchor) = 0;
  virtual Result<void> DeleteAnchor(const SharedAnchor& anchor) = 0;
  /// The same without waiting: shown at once, marked as pending, until the server has answered.
  /// More changes of an anchor may be begun meanwhile: each is made on top of the one before, fails
  /// with it, and of moves only the latest is sent. Errors here: those known at once.
  virtual Result<SharedAnchor> BeginPlace(const Transform<Device, Anchor>& device_from_anchor,
                                          const std::string& kind, const std::string& payload,
                                          content::AnchorVisibility audience) = 0;
  virtual Result<void> BeginMove(const SharedAnchor& anchor,
                                 const Transform<Map, Anchor>& map_from_anchor) = 0;
  virtual Result<void> BeginDelete(const SharedAnchor& anchor) = 0;
  /// Of changes begun, those that ended since it was last asked, in their order.
  virtual std::vector<EditOutcome> TakeOutcomes() = 0;

  /// All anchors that this phone may see, of the room or of the area around it; complete once
  /// `HasSnapshot`.
  virtual std::vector<SharedAnchor> Anchors() const = 0;
  virtual std::optional<SharedAnchor> FindAnchor(const AnchorId& anchor) const = 0;
  virtual bool HasSnapshot() const = 0;

  /// Counts up whenever others, anchors, standing or map may have changed, but not for their poses:
  /// cheap to ask every frame, before asking for these.
  virtual std::uint64_t Changes() const = 0;

  virtual DeviceStatistics Statistics() const = 0;
  /// Leaves at once for the others; the destructor does it too.
  virtual void Leave() = 0;
};

}  // namespace waymark::session
