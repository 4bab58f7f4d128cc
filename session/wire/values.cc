// SPDX-License-Identifier: Apache-2.0
#include "session/wire/internal/values.h"

namespace waymark::session::wire {
namespace {

constexpr double kQuaternionTolerance = 1e-3;  // of the norm; float rounding is far below

Result<Rigid3> MakeRigid(const Eigen::Vector3d& position, const Eigen::Vector4d& xyzw,
                         std::string_view field) {
  for (const double coordinate : position) {
    WAYMARK_TRY(CheckRange(coordinate, -kMaxCoordinate_m, kMaxCoordinate_m, field));
  }
  const double norm = xyzw.norm();
  if (!(std::abs(norm - 1) <= kQuaternionTolerance)) {  // also true for NaN
    return MakeError(ErrorCode::kInvalidArgument, "{}: expected a unit quaternion, found norm {}",
                     field, norm);
  }
  return Rigid3(Eigen::Quaterniond(xyzw.w(), xyzw.x(), xyzw.y(), xyzw.z()), position);
}

bool IsContinuation(unsigned char byte) { return (byte & 0xc0) == 0x80; }

/// Bytes of the well-formed character that starts here; 0 for none or a control character.
std::size_t CharacterLength(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return first < 0x20 || first == 0x7f ? 0 : 1;
  const std::size_t length = first >= 0xc2 && first <= 0xdf   ? 2
                             : first >= 0xe0 && first <= 0xef ? 3
                             : first >= 0xf0 && first <= 0xf4 ? 4
                                                              : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (!IsContinuation(byte(i))) return 0;
  }
  if (first == 0xe0 && byte(1) < 0xa0) return 0;  // longer than needed
  if (first == 0xed && byte(1) > 0x9f) return 0;  // surrogate
  if (first == 0xf0 && byte(1) < 0x90) return 0;
  if (first == 0xf4 && byte(1) > 0x8f) return 0;  // beyond U+10FFFF
  return length;
}

}  // namespace

void SetUuid(waymark_Uuid& field, const Uuid& uuid) { std::copy(uuid.begin(), uuid.end(), field); }

Uuid GetUuid(const waymark_Uuid& field) {
  Uuid uuid;
  std::copy_n(field, uuid.size(), uuid.begin());
  return uuid;
}

waymark_Pose EncodePose(const Rigid3& rigid) {
  waymark_Pose pose{};
  Eigen::Map<Eigen::Vector3d>(pose.position_m) = rigid.translation();
  Eigen::Map<Eigen::Vector4d>(pose.quaternion_xyzw) = rigid.rotation().coeffs();
  return pose;
}

Result<Rigid3> DecodePose(const waymark_Pose& pose, std::string_view field) {
  return MakeRigid(Eigen::Map<const Eigen::Vector3d>(pose.position_m),
                   Eigen::Map<const Eigen::Vector4d>(pose.quaternion_xyzw), field);
}

void EncodeCompactPose(const Rigid3& rigid, float (&position)[3], float (&quaternion)[4]) {
  Eigen::Map<Eigen::Vector3f> position_map(position);
  Eigen::Map<Eigen::Vector4f> quaternion_map(quaternion);
  position_map = rigid.translation().cast<float>();
  quaternion_map = rigid.rotation().coeffs().cast<float>();
}

Result<Rigid3> DecodeCompactPose(const float (&position)[3], const float (&quaternion)[4],
                                 std::string_view field) {
  return MakeRigid(Eigen::Map<const Eigen::Vector3f>(position).cast<double>(),
                   Eigen::Map<const Eigen::Vector4f>(quaternion).cast<double>(), field);
}

waymark_GeoPosition EncodeGeo(const GeoPoint& place) {
  return {.latitude_deg = place.latitude.degrees(),
          .longitude_deg = place.longitude.degrees(),
          .ellipsoid_height_m = place.ellipsoid_height_m};
}

Result<GeoPoint> DecodeGeo(const waymark_GeoPosition& position, std::string_view field) {
  WAYMARK_TRY(CheckRange(position.ellipsoid_height_m, -20'000, 1e6, field));
  const GeoPoint place{.latitude = Angle::Degrees(position.latitude_deg),
                       .longitude = Angle::Degrees(position.longitude_deg),
                       .ellipsoid_height_m = position.ellipsoid_height_m};
  WAYMARK_TRY(place.Validate());
  return place;
}

Result<CameraModel> DecodeCamera(const waymark_CameraIntrinsics& camera) {
  constexpr int kMaxSide_px = 16'384;
  WAYMARK_TRY_ASSIGN(const CameraKind kind,
                     DecodeEnum(camera.kind, CameraKind::kOpenCv, "camera kind"));
  WAYMARK_TRY(CheckRange(camera.width_px, 1, kMaxSide_px, "image width"));
  WAYMARK_TRY(CheckRange(camera.height_px, 1, kMaxSide_px, "image height"));
  return CameraModel::Create(kind, static_cast<int>(camera.width_px),
                             static_cast<int>(camera.height_px), Items(camera.parameters));
}

Result<void> CheckRange(double value, double low, double high, std::string_view field) {
  if (value >= low && value <= high) return {};
  return MakeError(ErrorCode::kInvalidArgument, "{}: expected [{}, {}], found {}", field, low, high,
                   value);
}

Result<void> CheckText(std::string_view text, std::size_t max_bytes, std::string_view field) {
  if (text.size() > max_bytes) {
    return MakeError(ErrorCode::kInvalidArgument, "{}: expected at most {} bytes, found {}", field,
                     max_bytes, text.size());
  }
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = CharacterLength(text.substr(i));
    if (length == 0) {
      return MakeError(ErrorCode::kInvalidArgument, "{}: byte {} is not printable UTF-8", field, i);
    }
    i += length;
  }
  return {};
}

Result<void> CheckName(std::string_view text, std::string_view field) {
  const auto is_allowed = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  if (!text.empty() && text.size() <= kMaxNameBytes &&
      std::all_of(text.begin(), text.end(), is_allowed)) {
    return {};
  }
  // The text itself is not repeated: it may be anything.
  return MakeError(ErrorCode::kInvalidArgument,
                   "{}: expected 1 to {} of A-Z a-z 0-9 _ -, found {} bytes with others", field,
                   kMaxNameBytes, text.size());
}

}  // namespace waymark::session::wire
