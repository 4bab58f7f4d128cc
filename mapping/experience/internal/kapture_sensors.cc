// SPDX-License-Identifier: Apache-2.0
#include "mapping/experience/internal/kapture_sensors.h"

#include <algorithm>
#include <array>
#include <set>

#include "mapping/experience/internal/kapture_table.h"

namespace waymark::mapping::internal {
namespace {

struct KindName {
  std::string_view name;
  SensorKind kind;
};

constexpr std::array<KindName, 9> kKindNames{{
    {"camera", SensorKind::kCamera},
    {"gnss", SensorKind::kGnss},
    {"accelerometer", SensorKind::kAccelerometer},
    {"gyroscope", SensorKind::kGyroscope},
    {"depth", SensorKind::kOther},
    {"lidar", SensorKind::kOther},
    {"wifi", SensorKind::kOther},
    {"bluetooth", SensorKind::kOther},
    {"magnetic", SensorKind::kOther},
}};

constexpr std::string_view kModels =
    "camera model SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV or UNKNOWN_CAMERA";

Result<SensorKind> ReadKind(const KaptureRow& row) {
  const auto* entry = std::find_if(kKindNames.begin(), kKindNames.end(),
                                   [&](const auto& k) { return k.name == row.Field(2); });
  if (entry != kKindNames.end()) return entry->kind;
  return row.Wrong(ErrorCode::kUnsupported,
                   "a sensor type such as camera, gnss, accelerometer or gyroscope",
                   Quoted(row.Field(2)));
}

Result<CameraModel> ReadKnownCamera(const KaptureRow& row, CameraKind kind, int width_px,
                                    int height_px) {
  constexpr std::size_t kFirst = 6;
  WAYMARK_TRY(
      row.CheckFieldCount(kFirst + ParameterCount(kind),
                          fmt::format("id, name, camera, {}, width, height and {} parameters",
                                      CameraKindName(kind), ParameterCount(kind))));
  std::vector<double> parameters(ParameterCount(kind));
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    WAYMARK_TRY_ASSIGN(parameters[i], row.Number(kFirst + i, "camera parameter", 1e6));
  }
  auto model = CameraModel::Create(kind, width_px, height_px, parameters);
  if (!model) {
    return row.Wrong(ErrorCode::kCorrupt, "a possible camera",
                     fmt::format("an impossible one ({})", model.error().message));
  }
  return model;
}

Result<CameraSensor> ReadCamera(const KaptureRow& row, const std::string& id) {
  constexpr std::string_view kColumns = "id, name, camera, model, width, height, parameters";
  if (row.field_count() < 6) WAYMARK_TRY(row.CheckFieldCount(6, kColumns));
  const auto kind = FindCameraKind(row.Field(3));
  const bool is_unknown = row.Field(3) == "UNKNOWN_CAMERA";
  if (!kind && !is_unknown) {
    return row.Wrong(ErrorCode::kUnsupported, kModels, Quoted(row.Field(3)));
  }
  constexpr std::int64_t kMaxSide = 100000;
  WAYMARK_TRY_ASSIGN(const auto width, row.Integer(4, "image width", 1, kMaxSide));
  WAYMARK_TRY_ASSIGN(const auto height, row.Integer(5, "image height", 1, kMaxSide));
  const int width_px = static_cast<int>(width);
  const int height_px = static_cast<int>(height);
  auto model = is_unknown ? GuessCameraModel(width_px, height_px)
                          : ReadKnownCamera(row, *kind, width_px, height_px);
  if (!model) return model.error();
  return CameraSensor{id, *std::move(model), !is_unknown};
}

/// kapture's GNSS coordinates name their reference system; degrees on WGS84 is what we read.
Result<void> CheckGnssSystem(const KaptureRow& row) {
  if (row.field_count() < 4 || row.Field(3).empty() || row.Field(3) == "EPSG:4326") return {};
  return row.Wrong(ErrorCode::kUnsupported, "GNSS coordinates as EPSG:4326", Quoted(row.Field(3)));
}

Result<void> ReadSensor(const KaptureRow& row, KaptureSensors& sensors) {
  if (row.field_count() < 3) WAYMARK_TRY(row.CheckFieldCount(3, "id, name, type, parameters"));
  WAYMARK_TRY_ASSIGN(const std::string id, row.Name(0, "sensor id"));
  WAYMARK_TRY_ASSIGN(const SensorKind kind, ReadKind(row));
  if (!sensors.kinds.emplace(id, kind).second) {
    return row.Wrong(ErrorCode::kCorrupt, "each sensor once", Quoted(id) + " again");
  }
  if (kind == SensorKind::kCamera) {
    WAYMARK_TRY_ASSIGN(CameraSensor camera, ReadCamera(row, id));
    sensors.cameras.emplace(id, std::move(camera));
  }
  if (kind == SensorKind::kGnss) WAYMARK_TRY(CheckGnssSystem(row));
  return {};
}

Result<void> ReadRigMember(const KaptureRow& row, std::set<std::string>& members,
                           KaptureSensors& sensors) {
  WAYMARK_TRY(row.CheckFieldCount(9, "rig, sensor, qw, qx, qy, qz, tx, ty, tz"));
  WAYMARK_TRY_ASSIGN(std::string rig, row.Name(0, "rig id"));
  WAYMARK_TRY_ASSIGN(std::string sensor, row.Name(1, "sensor id"));
  if (sensors.kinds.contains(rig)) {
    return row.Wrong(ErrorCode::kCorrupt, "a rig id that is no sensor", Quoted(rig));
  }
  if (!sensors.kinds.contains(sensor)) {
    return row.Wrong(ErrorCode::kCorrupt, "a sensor of sensors.txt (rigs within rigs are not read)",
                     Quoted(sensor));
  }
  if (!members.insert(sensor).second) {
    return row.Wrong(ErrorCode::kCorrupt, "each sensor in one rig", Quoted(sensor) + " again");
  }
  WAYMARK_TRY_ASSIGN(const Rigid3 sensor_from_rig, row.Pose(2));
  sensors.rigs.push_back({std::move(rig), std::move(sensor), sensor_from_rig});
  return {};
}

}  // namespace

bool KaptureSensors::IsRig(const std::string& device) const {
  return std::any_of(rigs.begin(), rigs.end(), [&](const auto& m) { return m.rig == device; });
}

Result<CameraModel> GuessCameraModel(int width_px, int height_px) {
  const std::array<double, 4> parameters{1.2 * std::max(width_px, height_px), width_px / 2.0,
                                         height_px / 2.0, 0};
  return CameraModel::Create(CameraKind::kSimpleRadial, width_px, height_px, parameters);
}

Result<KaptureSensors> LoadKaptureSensors(const std::filesystem::path& sensors_folder) {
  KaptureSensors sensors;
  WAYMARK_TRY(ForEachRow(sensors_folder / "sensors.txt",
                         [&](const KaptureRow& row) { return ReadSensor(row, sensors); }));
  const auto rigs = sensors_folder / "rigs.txt";
  std::error_code ignored;
  if (!std::filesystem::exists(rigs, ignored)) return sensors;
  std::set<std::string> members;
  WAYMARK_TRY(ForEachRow(
      rigs, [&](const KaptureRow& row) { return ReadRigMember(row, members, sensors); }));
  return sensors;
}

}  // namespace waymark::mapping::internal
