// SPDX-License-Identifier: Apache-2.0
#include "session/device/c/values.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mapping/features/features.h"

namespace waymark::session::c {
namespace {

constexpr int kMaxSide_px = 1 << 15;

// The room's is 0: what an app says that knows no audiences.
constexpr std::array<std::pair<content::AnchorVisibility, std::int32_t>, 3> kAudiences{
    {{content::AnchorVisibility::kRoom, WAYMARK_FOR_ROOM},
     {content::AnchorVisibility::kPrivate, WAYMARK_FOR_OWNER},
     {content::AnchorVisibility::kPublic, WAYMARK_PUBLIC}}};

static_assert(static_cast<int>(Role::kMember) == WAYMARK_MEMBER &&
              static_cast<int>(Role::kViewer) == WAYMARK_VIEWER &&
              static_cast<int>(Role::kModerator) == WAYMARK_MODERATOR);
static_assert(static_cast<int>(localiser::AlignmentState::kNever) == WAYMARK_NEVER &&
              static_cast<int>(localiser::AlignmentState::kCoarse) == WAYMARK_COARSE &&
              static_cast<int>(localiser::AlignmentState::kFixed) == WAYMARK_FIXED &&
              static_cast<int>(localiser::AlignmentState::kStale) == WAYMARK_STALE);
static_assert(static_cast<int>(CameraKind::kSimplePinhole) == WAYMARK_SIMPLE_PINHOLE &&
              static_cast<int>(CameraKind::kPinhole) == WAYMARK_PINHOLE &&
              static_cast<int>(CameraKind::kSimpleRadial) == WAYMARK_SIMPLE_RADIAL &&
              static_cast<int>(CameraKind::kRadial) == WAYMARK_RADIAL &&
              static_cast<int>(CameraKind::kOpenCv) == WAYMARK_OPENCV);

/// Copies the rows without what pads them.
Result<mapping::GrayImage> ReadGrey(const WaymarkFrame& theirs) {
  const bool has_size = theirs.width_px > 0 && theirs.height_px > 0 &&
                        theirs.width_px <= kMaxSide_px && theirs.height_px <= kMaxSide_px;
  const std::int64_t row = theirs.row_bytes == 0 ? theirs.width_px : theirs.row_bytes;
  const std::int64_t needed = row * (theirs.height_px - std::int64_t{1}) + theirs.width_px;
  if (!has_size || row < theirs.width_px ||
      theirs.image_bytes < static_cast<std::uint64_t>(needed)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "frame: expected {} x {} pixels in rows of {} bytes, found {} bytes",
                     theirs.width_px, theirs.height_px, row, theirs.image_bytes);
  }
  mapping::GrayImage image{
      .width_px = theirs.width_px, .height_px = theirs.height_px, .pixels = {}};
  image.pixels.reserve(static_cast<std::size_t>(image.width_px) * image.height_px);
  const auto* at = static_cast<const std::uint8_t*>(theirs.image);
  for (int y = 0; y < image.height_px; ++y, at += row) {
    image.pixels.insert(image.pixels.end(), at, at + image.width_px);
  }
  return image;
}

Result<mapping::GrayImage> ReadImage(const WaymarkFrame& theirs) {
  WAYMARK_TRY(Need(theirs.image, "frame's image"));
  if (theirs.format == WAYMARK_GREY) return ReadGrey(theirs);
  if (theirs.format == WAYMARK_JPEG) {
    return mapping::DecodeGrayImage(
        {static_cast<const std::uint8_t*>(theirs.image), theirs.image_bytes});
  }
  return MakeError(ErrorCode::kInvalidArgument,
                   "frame's format: expected WAYMARK_GREY or WAYMARK_JPEG, found {}",
                   theirs.format);
}

Result<CameraModel> ReadCamera(const WaymarkFrame& theirs) {
  if (theirs.camera_kind < WAYMARK_SIMPLE_PINHOLE || theirs.camera_kind > WAYMARK_OPENCV) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "frame's camera: expected a kind in [0, {}], found {}",
                     static_cast<int>(WAYMARK_OPENCV), theirs.camera_kind);
  }
  const auto kind = static_cast<CameraKind>(theirs.camera_kind);
  return CameraModel::Create(kind, theirs.width_px, theirs.height_px,
                             std::span(theirs.camera_parameters).first(ParameterCount(kind)));
}

Result<void> ReadSenses(const WaymarkFrame& theirs, DeviceFrame& frame) {
  if (theirs.has_up != 0) {
    const Eigen::Vector3d up(theirs.up_in_camera);
    if (!up.allFinite() || !(up.norm() > 1e-6)) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "frame's up: expected a direction, found ({}, {}, {})", up.x(), up.y(),
                       up.z());
    }
    frame.up_in_camera = up.normalized();
  }
  if (theirs.has_gnss == 0) return {};
  const GeoPoint place{.latitude = Angle::Degrees(theirs.latitude_deg),
                       .longitude = Angle::Degrees(theirs.longitude_deg),
                       .ellipsoid_height_m = theirs.ellipsoid_height_m};
  const bool is_on_earth = place.Validate().ok() && std::abs(place.ellipsoid_height_m) < 1e5;
  if (!is_on_earth || !(theirs.gnss_sigma_m > 0) || !std::isfinite(theirs.gnss_sigma_m)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "frame's GNSS: expected degrees, metres and a sigma above 0, found {}, {}, {} "
                     "and {}",
                     theirs.latitude_deg, theirs.longitude_deg, theirs.ellipsoid_height_m,
                     theirs.gnss_sigma_m);
  }
  frame.gnss = place;
  frame.gnss_sigma_m = theirs.gnss_sigma_m;
  return {};
}

}  // namespace

Result<Rigid3> ReadRigid(const WaymarkTransform* theirs, const char* name) {
  WAYMARK_TRY(Need(theirs, name));
  const Eigen::Vector3d translation(theirs->translation_m);
  const Eigen::Quaterniond rotation(theirs->rotation_xyzw);  // x, y, z, w in memory, as in Eigen
  constexpr double kMaxOff = 1e-3;
  if (!translation.allFinite() || !(std::abs(rotation.norm() - 1) < kMaxOff)) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "{}: expected finite metres and a unit quaternion, found ({}, {}, {}) and "
                     "length {}",
                     name, translation.x(), translation.y(), translation.z(), rotation.norm());
  }
  return Rigid3(rotation, translation);
}

Result<DeviceFrame> ReadFrame(const WaymarkFrame& theirs) {
  WAYMARK_TRY_ASSIGN(mapping::GrayImage image, ReadImage(theirs));
  WAYMARK_TRY_ASSIGN(CameraModel camera, ReadCamera(theirs));
  WAYMARK_TRY_ASSIGN(
      const auto device_from_camera,
      (ReadTransform<Device, Camera>(&theirs.device_from_camera, "frame's device_from_camera")));
  WAYMARK_TRY_ASSIGN(const auto vo_from_device,
                     (ReadTransform<Vo, Device>(&theirs.vo_from_device, "frame's vo_from_device")));
  DeviceFrame frame{.width_px = image.width_px,
                    .height_px = image.height_px,
                    .pixels = std::move(image.pixels),
                    .camera = std::move(camera),
                    .device_from_camera = device_from_camera,
                    .vo_from_device = vo_from_device,
                    .time = FromNanoseconds<DeviceTime>(theirs.time_ns)};
  WAYMARK_TRY(ReadSenses(theirs, frame));
  return frame;
}

Result<SharedAnchor> ReadAnchor(const WaymarkAnchor* held) {
  WAYMARK_TRY_ASSIGN(const WaymarkAnchor theirs, ReadStruct(held, "held"));
  WAYMARK_TRY_ASSIGN(const std::string id,
                     ReadText(theirs.anchor, WAYMARK_ID_BYTES - 1, "anchor's id"));
  return SharedAnchor{.id = AnchorId(id),
                      .owner = DeviceId(""),
                      .map_from_anchor = {},
                      .epoch = theirs.epoch,
                      .revision = theirs.revision,
                      .kind = "",
                      .payload = ""};
}

Result<content::AnchorVisibility> ReadAudience(std::int32_t theirs) {
  for (const auto& [ours, c] : kAudiences) {
    if (c == theirs) return ours;
  }
  return MakeError(ErrorCode::kInvalidArgument,
                   "audience: expected WAYMARK_FOR_ROOM, WAYMARK_FOR_OWNER or WAYMARK_PUBLIC, "
                   "found {}",
                   theirs);
}

WaymarkTransform ToC(const Rigid3& rigid) {
  WaymarkTransform c;
  std::copy_n(rigid.translation().data(), 3, c.translation_m);
  Eigen::Quaterniond rotation = rigid.rotation();
  if (rotation.w() < 0) rotation.coeffs() *= -1;  // the same, and apps may compare
  std::copy_n(rotation.coeffs().data(), 4, c.rotation_xyzw);
  return c;
}

WaymarkPose ToC(const DevicePose& pose) {
  WaymarkPose c{};
  c.state = static_cast<std::int32_t>(pose.state);
  c.has_pose = pose.map_from_device.has_value();
  c.fix_source = static_cast<std::int32_t>(pose.fix_source);
  c.epoch = pose.epoch;
  c.time_ns = ToNanoseconds(pose.time);
  c.map_from_device = ToC(pose.map_from_device.value_or(Transform<Map, Device>()).rigid());
  std::copy_n(pose.covariance.data(), 36, c.covariance);  // symmetric: by rows as by columns
  return c;
}

WaymarkOther ToC(const OtherDevice& other) {
  WaymarkOther c{};
  c.is_present = other.is_present;
  c.role = static_cast<std::int32_t>(other.role);
  c.has_pose = other.map_from_device.has_value();
  c.epoch = other.epoch;
  c.map_from_device = ToC(other.map_from_device.value_or(Transform<Map, Device>()).rigid());
  c.sigma_m = other.sigma_m;
  c.age_s = other.age.count();
  WriteText(other.id.text(), c.device, sizeof(c.device));
  WriteText(other.name, c.name, sizeof(c.name));
  c.rotation_sigma_rad = other.rotation_sigma_rad;
  c.known_sigma_m = other.certainty.sigma_m;
  c.known_rotation_sigma_rad = other.certainty.rotation_sigma_rad;
  c.state = static_cast<std::int32_t>(other.tracking);
  return c;
}

WaymarkAnchor ToC(const SharedAnchor& anchor) {
  WaymarkAnchor c{};
  c.is_supported = anchor.is_supported;
  c.epoch = anchor.epoch;
  c.revision = anchor.revision;
  c.payload_bytes = anchor.payload.size();
  c.map_from_anchor = ToC(anchor.map_from_anchor.rigid());
  WriteText(anchor.id.text(), c.anchor, sizeof(c.anchor));
  WriteText(anchor.owner.text(), c.owner, sizeof(c.owner));
  WriteText(anchor.kind, c.kind, sizeof(c.kind));
  for (const auto& [ours, theirs] : kAudiences) {
    if (ours == anchor.audience) c.audience = theirs;
  }
  c.is_pending = anchor.is_pending;
  return c;
}

WaymarkEvent ToC(const Event& event) {
  WaymarkEvent c{};
  c.kind = event.kind;
  c.value = event.value;
  WriteText(event.id, c.id, sizeof(c.id));
  return c;
}

}  // namespace waymark::session::c
