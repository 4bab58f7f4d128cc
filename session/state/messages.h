// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "localiser/localiser.h"
#include "mapping/base/id.h"
#include "mapping/base/time.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/frames.h"
#include "mapping/geometry/geodesy.h"
#include "session/state/anchors.h"
#include "session/state/poses.h"
#include "session/state/role.h"
#include "session/state/uuid.h"

/// What devices and the server say to each other, as plain values; idl/README.md has the topics.
namespace waymark::session {

inline constexpr std::uint32_t kProtocol = 4;
/// Who speaks an earlier one is told so and refused: poses have another layout since.
inline constexpr std::uint32_t kOldestProtocol = 4;

// Nothing that arrives may exceed these; the store and the bus rely on them.
inline constexpr std::size_t kMaxNameBytes = 64;
inline constexpr std::size_t kMaxKindBytes = 255;
inline constexpr std::size_t kMaxReasonBytes = 255;
inline constexpr std::size_t kMaxTokenBytes = 512;
inline constexpr std::size_t kMaxOwnerSecretBytes = 128;
inline constexpr std::size_t kMaxPayloadBytes = 64 * 1024;
inline constexpr std::size_t kMaxImageBytes = 4 * 1024 * 1024;
inline constexpr std::size_t kMaxEarlierImages = 15;  ///< of a query
inline constexpr std::size_t kMaxPlacements = 256;    ///< of a MapState
inline constexpr std::size_t kMaxAttachments = 3;
inline constexpr std::size_t kMaxPerGatewayReport = 64;  ///< poses, pings, pongs
inline constexpr double kMaxCoordinate_m = 1e6;

enum class RequestNumber : std::uint32_t {};  ///< of a localisation, counted by the device

// ---- joining ----------------------------------------------------------------------------------

struct Hello {
  DeviceId device;  ///< UUID, chosen by the device and kept for its life
  std::uint32_t protocol = kProtocol;
  std::uint32_t attempt = 1;      ///< grows with every join of this device
  RoomId room;                    ///< 1 to 64 of A-Z a-z 0-9 _ -
  std::string name;               ///< at most 64 bytes of printable UTF-8
  std::string token = {};         ///< see session/keys/token.h; never kept, logged or recorded
  std::string owner_secret = {};  ///< see session/keys/owner.h; likewise
  AnchorScope anchor_scope = AnchorScope::kRoom;
};

/// kRemoved ends what an earlier welcome began.
enum class JoinVerdict : std::uint8_t { kAccepted, kInvalid, kRefused, kUnavailable, kRemoved };

/// Which map a room stands in.
struct MapIdentity {
  std::string map;
  bool is_geo_aligned = true;
  GeoPoint origin;
  std::uint64_t epoch = 1;
};

struct Welcome {
  DeviceId device;
  std::uint32_t attempt = 0;  ///< of the Hello it answers
  JoinVerdict verdict = JoinVerdict::kAccepted;
  std::string reason = {};  ///< empty when accepted
  RunId run{};
  Ticket ticket{};
  DeviceNumber number{};
  MapIdentity map = {};
  ServerTime session_time = {};
  Role role = Role::kMember;
  bool is_return = false;              ///< it was here shortly before, and is itself again
  std::uint32_t protocol = kProtocol;  ///< of the server
  std::string owner = {};              ///< of what the device places
};

struct Presence {
  DeviceId device;
  DeviceNumber number{};
  std::string name;
  RunId run{};
  Role role = Role::kMember;
};

enum class RoomOperation : std::uint8_t { kRemoveDevice, kReadmitDevice, kSetCapacity };

/// What a moderator wants of the room; a CommandReply without an anchor answers it.
struct RoomCommand {
  Ticket ticket{};
  Uuid request{};  ///< the same in every repetition
  RoomOperation operation = RoomOperation::kRemoveDevice;
  DeviceId device{FormatUuid({})};  ///< remove, readmit
  std::uint32_t capacity = 0;       ///< set capacity
  std::string reason = {};          ///< remove: told to the device
};

// ---- localisation -----------------------------------------------------------------------------

struct GeoPrior {
  GeoPoint position;
  double sigma_m = 10;
};

/// An image of a device that an earlier query asked about, and that was not found.
struct EarlierImage {
  RequestNumber request{};
  Transform<Vo, Camera> vo_from_camera;
};

struct LocaliseQuery {
  Ticket ticket{};
  RequestNumber request{};
  DeviceTime time;  ///< when the image was taken
  CameraModel camera;
  std::optional<GeoPrior> prior;
  std::optional<Eigen::Vector3d> up_in_camera;
  std::vector<std::uint8_t> image;  ///< JPEG, or encoded features
  /// Where odometry (metres, z up) saw the camera. With it, an image that is not found may be kept
  /// for the device's next queries.
  std::optional<Transform<Vo, Camera>> vo_from_camera = {};
  /// To be asked together with this one if it is not found alone; of the same odometry, oldest
  /// first, at most kMaxEarlierImages.
  std::vector<EarlierImage> earlier = {};
};

enum class LocaliseStatus : std::uint8_t {
  kLocalised,
  kTooFewFeatures,
  kNothingNear,
  kTooFewMatches,
  kNoConsistentPose,
  kBusy,
  kInvalidImage,
};

struct LocaliseAnswer {
  DeviceId device;
  RequestNumber request{};
  LocaliseStatus status = LocaliseStatus::kBusy;
  std::string reason = {};
  std::uint64_t epoch = 1;
  std::optional<localiser::LocalisedPose> pose = {};  ///< present exactly when kLocalised
  double queue_ms = 0;
  localiser::StageTimes times = {};
  ServerTime received = {};  ///< the query
  ServerTime sent = {};
};

// ---- releases ---------------------------------------------------------------------------------

/// Where submaps lie in a release.
using Placements = std::map<SubmapId, Similarity<Map, Submap>>;

/// Another release went live under the room.
struct MapState {
  RoomId room;
  RunId run{};
  std::uint32_t swap = 0;  ///< counts the changes in this run; a rollback counts up too
  std::uint64_t epoch = 1;
  Placements placements = {};  ///< of the submaps that fixes and anchors of the room hold on to
};

// ---- clock ------------------------------------------------------------------------------------

struct ClockPing {
  Ticket ticket{};
  std::uint32_t sequence_number = 0;
  DeviceTime sent;
};

struct ClockPong {
  DeviceId device;
  std::uint32_t sequence_number = 0;
  DeviceTime device_sent = {};
  ServerTime received = {};
  ServerTime sent = {};
  RunId run{};
};

// ---- gateways ---------------------------------------------------------------------------------

enum class GatewayId : std::uint64_t {};  ///< one life of a gateway process

/// What phones of a gateway said since the last one.
struct GatewayReport {
  GatewayId gateway{};
  std::vector<PoseReport> poses;
  std::vector<ClockPing> pings;
};

struct GatewayPongs {
  GatewayId gateway{};
  std::vector<ClockPong> pongs;
};

}  // namespace waymark::session
