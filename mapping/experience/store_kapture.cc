// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <string>

#include "mapping/base/file.h"
#include "mapping/experience/internal/kapture_table.h"
#include "mapping/experience/kapture.h"
#include "mapping/experience/names.h"

namespace waymark::mapping {
namespace {

/// Type by sensor id, as kapture names types.
using SensorTypes = std::map<std::string, std::string_view>;

/// Appends formatted text to a table.
template <typename... Args>
void Append(std::string& table, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(table), format, std::forward<Args>(args)...);
}

std::string NewTable(std::string_view columns) {
  return fmt::format("{}\n# {}\n", internal::kKaptureHeader, columns);
}

/// kapture has no quoting, so a field must survive splitting at commas and trimming.
Result<void> CheckField(std::string_view text, std::string_view what) {
  const bool is_whole = !text.empty() && text.size() <= 1000 && IsPrintableText(text) &&
                        text.find(',') == std::string_view::npos && text.front() != '#' &&
                        text.front() != ' ' && text.back() != ' ';
  if (is_whole) return {};
  return MakeError(ErrorCode::kInvalidArgument,
                   "kapture {}: expected printable text without commas or outer blanks, found {}",
                   what, internal::Quoted(text));
}

Result<void> CheckTime(SensorTime time) {
  if (ToNanoseconds(time) >= 0 && ToNanoseconds(time) < std::int64_t{1} << 62) return {};
  return MakeError(ErrorCode::kInvalidArgument,
                   "kapture timestamp: expected nanoseconds from 0 to 2^62, found {}",
                   ToNanoseconds(time));
}

Result<void> CheckPose(const Rigid3& pose, std::string_view device) {
  if (pose.translation().allFinite() && pose.rotation().coeffs().allFinite()) return {};
  return MakeError(ErrorCode::kInvalidArgument, "device {}: expected a finite pose", device);
}

void AppendPose(std::string& table, const Rigid3& pose) {
  const auto& q = pose.rotation();
  const auto& t = pose.translation();
  Append(table, "{}, {}, {}, {}, {}, {}, {}\n", q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z());
}

void AppendCamera(std::string& table, std::string_view id, const CameraSensor& camera) {
  const CameraModel& model = camera.model;
  Append(table, "{}, , camera, {}, {}, {}", id,
         camera.has_known_focal ? CameraKindName(model.kind()) : "UNKNOWN_CAMERA", model.width_px(),
         model.height_px());
  if (camera.has_known_focal) {
    for (const double parameter : model.parameters()) Append(table, ", {}", parameter);
  }
  table += '\n';
}

/// Notes a sensor that only its records mention.
template <typename Record>
Result<void> CollectSensors(const std::vector<Record>& records, std::string_view type,
                            SensorTypes& types) {
  for (const Record& record : records) {
    const auto [entry, is_new] = types.emplace(record.sensor, type);
    if (is_new) WAYMARK_TRY(CheckField(record.sensor, "sensor id"));
    if (entry->second == type) continue;
    return MakeError(ErrorCode::kInvalidArgument, "sensor {}: expected one type, found {} and {}",
                     record.sensor, entry->second, type);
  }
  return {};
}

/// The types of all sensors that have a model or a record.
Result<SensorTypes> FindSensorTypes(const Experience& experience) {
  SensorTypes types;
  for (const auto& [id, camera] : experience.cameras) {
    WAYMARK_TRY(CheckField(id, "camera id"));
    types.emplace(id, "camera");
  }
  WAYMARK_TRY(CollectSensors(experience.gnss, "gnss", types));
  WAYMARK_TRY(CollectSensors(experience.accelerometer, "accelerometer", types));
  WAYMARK_TRY(CollectSensors(experience.gyroscope, "gyroscope", types));
  return types;
}

std::string EncodeSensors(const Experience& experience, const SensorTypes& types) {
  std::string table = NewTable("sensor_id, name, sensor_type, [sensor_params]+");
  for (const auto& [id, camera] : experience.cameras) AppendCamera(table, id, camera);
  for (const auto& [id, type] : types) {
    if (type == "camera") continue;
    Append(table, "{}, , {}{}\n", id, type, type == "gnss" ? ", EPSG:4326" : "");
  }
  return table;
}

Result<std::string> EncodeImages(const Experience& experience) {
  std::string table = NewTable("timestamp, device_id, image_path");
  for (const ImageRecord& image : experience.images) {
    WAYMARK_TRY(CheckTime(image.time));
    WAYMARK_TRY(CheckField(image.name, "image name"));
    if (!IsImageName(image.name) || !experience.cameras.contains(image.camera)) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "image {}: expected a path inside records_data and a known camera, found {}",
                       internal::Quoted(image.name), internal::Quoted(image.camera));
    }
    Append(table, "{}, {}, {}\n", ToNanoseconds(image.time), image.camera, image.name);
  }
  return table;
}

Result<std::string> EncodeGnss(const Experience& experience) {
  std::string table = NewTable("timestamp, device_id, x, y, z, utc, dop");
  for (const GnssRecord& record : experience.gnss) {
    WAYMARK_TRY(CheckTime(record.time));
    WAYMARK_TRY(record.place.Validate());
    if (!(record.sigma_m > 0 && record.sigma_m <= internal::kMaxGnssSigmaM) ||
        !(std::abs(record.place.ellipsoid_height_m) <= internal::kMaxHeightM)) {
      return MakeError(ErrorCode::kInvalidArgument,
                       "gnss {}: expected a sigma above 0 and a height near the ground, found {} m "
                       "and {} m",
                       record.sensor, record.sigma_m, record.place.ellipsoid_height_m);
    }
    Append(table, "{}, {}, {}, {}, {}, 0, {}\n", ToNanoseconds(record.time), record.sensor,
           record.place.longitude.degrees(), record.place.latitude.degrees(),
           record.place.ellipsoid_height_m, record.sigma_m);
  }
  return table;
}

Result<std::string> EncodeImu(const std::vector<ImuRecord>& records) {
  std::string table = NewTable("timestamp, device_id, x, y, z");
  for (const ImuRecord& record : records) {
    WAYMARK_TRY(CheckTime(record.time));
    if (!record.value.allFinite()) {
      return MakeError(ErrorCode::kInvalidArgument, "sensor {}: expected finite values",
                       record.sensor);
    }
    Append(table, "{}, {}, {}, {}, {}\n", ToNanoseconds(record.time), record.sensor,
           record.value.x(), record.value.y(), record.value.z());
  }
  return table;
}

/// The members that can be declared: of a sensor without model or record the type is not known.
std::vector<RigMember> DeclaredMembers(const Experience& experience, const SensorTypes& types) {
  std::vector<RigMember> members;
  std::copy_if(experience.rigs.begin(), experience.rigs.end(), std::back_inserter(members),
               [&](const RigMember& member) { return types.contains(member.sensor); });
  return members;
}

Result<std::string> EncodeRigs(const std::vector<RigMember>& members, const SensorTypes& types) {
  std::string table = NewTable("rig_id, sensor_id, qw, qx, qy, qz, tx, ty, tz");
  for (const RigMember& member : members) {
    WAYMARK_TRY(CheckField(member.rig, "rig id"));
    WAYMARK_TRY(CheckPose(member.sensor_from_rig, member.rig));
    if (types.contains(member.rig)) {
      return MakeError(ErrorCode::kInvalidArgument, "rig {}: expected an id that is no sensor's",
                       member.rig);
    }
    Append(table, "{}, {}, ", member.rig, member.sensor);
    AppendPose(table, member.sensor_from_rig);
  }
  return table;
}

Result<std::string> EncodeTrajectory(const Experience& experience, const SensorTypes& types,
                                     const std::vector<RigMember>& members) {
  std::set<std::string> devices;
  for (const auto& [id, type] : types) devices.insert(id);
  for (const RigMember& member : members) devices.insert(member.rig);
  std::string table = NewTable("timestamp, device_id, qw, qx, qy, qz, tx, ty, tz");
  for (const TrajectoryRecord& record : experience.trajectory) {
    WAYMARK_TRY(CheckTime(record.time));
    WAYMARK_TRY(CheckPose(record.device_from_world, record.device));
    if (!devices.contains(record.device)) {
      return MakeError(ErrorCode::kInvalidArgument, "trajectory: expected known devices, found {}",
                       internal::Quoted(record.device));
    }
    Append(table, "{}, {}, ", ToNanoseconds(record.time), record.device);
    AppendPose(table, record.device_from_world);
  }
  return table;
}

}  // namespace

Result<void> StoreKapture(const Experience& experience, const std::filesystem::path& folder) {
  WAYMARK_TRY_ASSIGN(const SensorTypes types, FindSensorTypes(experience));
  const std::vector<RigMember> members = DeclaredMembers(experience, types);
  const std::string sensors = EncodeSensors(experience, types);
  WAYMARK_TRY_ASSIGN(const std::string rigs, EncodeRigs(members, types));
  WAYMARK_TRY_ASSIGN(const std::string images, EncodeImages(experience));
  WAYMARK_TRY_ASSIGN(const std::string gnss, EncodeGnss(experience));
  WAYMARK_TRY_ASSIGN(const std::string accelerometer, EncodeImu(experience.accelerometer));
  WAYMARK_TRY_ASSIGN(const std::string gyroscope, EncodeImu(experience.gyroscope));
  WAYMARK_TRY_ASSIGN(const std::string trajectory, EncodeTrajectory(experience, types, members));
  const auto tables = folder / "sensors";
  WAYMARK_TRY(CreateFolders(tables / "records_data"));
  const auto store = [&](std::string_view name, bool is_needed,
                         std::string_view text) -> Result<void> {
    if (is_needed) return StoreFileAtomically(tables / name, text);
    std::error_code ignored;
    std::filesystem::remove(tables / name, ignored);  // of an experience stored here before
    return {};
  };
  WAYMARK_TRY(store("rigs.txt", !members.empty(), rigs));
  WAYMARK_TRY(store("records_camera.txt", true, images));
  WAYMARK_TRY(store("records_gnss.txt", !experience.gnss.empty(), gnss));
  WAYMARK_TRY(store("records_accelerometer.txt", !experience.accelerometer.empty(), accelerometer));
  WAYMARK_TRY(store("records_gyroscope.txt", !experience.gyroscope.empty(), gyroscope));
  WAYMARK_TRY(store("trajectories.txt", !experience.trajectory.empty(), trajectory));
  return store("sensors.txt", true, sensors);  // last: without it the folder is no kapture
}

}  // namespace waymark::mapping
