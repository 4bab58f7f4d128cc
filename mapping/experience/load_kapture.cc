// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>
#include <utility>

#include "mapping/experience/internal/kapture_sensors.h"
#include "mapping/experience/internal/kapture_table.h"
#include "mapping/experience/kapture.h"
#include "mapping/experience/names.h"

namespace waymark::mapping {
namespace {

using internal::ForEachRow;
using internal::KaptureRow;
using internal::KaptureSensors;
using internal::Quoted;
using internal::SensorKind;

/// kapture writes 0 when the dilution of precision is unknown; a phone under open sky is within
/// about 5 m.
constexpr double kUnknownGnssSigmaM = 5;
/// The error that one unit of dilution stands for.
constexpr double kMetresPerDop = 1;

Result<std::string> ReadSensorId(const KaptureRow& row, const KaptureSensors& sensors,
                                 SensorKind kind, std::string_view kind_name) {
  WAYMARK_TRY_ASSIGN(std::string id, row.Name(1, "sensor id"));
  const auto found = sensors.kinds.find(id);
  if (found == sensors.kinds.end() || found->second != kind) {
    return row.Wrong(ErrorCode::kCorrupt, fmt::format("a {} of sensors.txt", kind_name),
                     Quoted(id));
  }
  return id;
}

Result<ImageRecord> ReadImage(const KaptureRow& row, const KaptureSensors& sensors) {
  WAYMARK_TRY(row.CheckFieldCount(3, "timestamp, camera, image"));
  WAYMARK_TRY_ASSIGN(const SensorTime time, row.Time(0));
  WAYMARK_TRY_ASSIGN(std::string camera, ReadSensorId(row, sensors, SensorKind::kCamera, "camera"));
  if (!IsImageName(row.Field(2))) {
    return row.Wrong(ErrorCode::kCorrupt, "an image path inside records_data",
                     Quoted(row.Field(2)));
  }
  return ImageRecord{time, std::move(camera), std::string(row.Field(2))};
}

Result<GnssRecord> ReadGnss(const KaptureRow& row, const KaptureSensors& sensors) {
  WAYMARK_TRY(row.CheckFieldCount(7, "timestamp, device, x, y, z, utc, dop"));
  WAYMARK_TRY_ASSIGN(const SensorTime time, row.Time(0));
  WAYMARK_TRY_ASSIGN(std::string sensor, ReadSensorId(row, sensors, SensorKind::kGnss, "gnss"));
  WAYMARK_TRY_ASSIGN(const double longitude_deg, row.Number(2, "x (longitude)", 180));
  WAYMARK_TRY_ASSIGN(const double latitude_deg, row.Number(3, "y (latitude)", 90));
  WAYMARK_TRY_ASSIGN(const double height_m, row.Number(4, "z (height)", internal::kMaxHeightM));
  WAYMARK_TRY_ASSIGN(const double dop, row.Number(6, "dop", internal::kMaxGnssSigmaM));
  if (dop < 0) return row.Wrong(ErrorCode::kCorrupt, "dop of at least 0", Quoted(row.Field(6)));
  const double sigma_m = dop > 0 ? dop * kMetresPerDop : kUnknownGnssSigmaM;
  return GnssRecord{time, std::move(sensor),
                    GeoPoint{Angle::Degrees(latitude_deg), Angle::Degrees(longitude_deg), height_m},
                    sigma_m};
}

Result<ImuRecord> ReadImu(const KaptureRow& row, const KaptureSensors& sensors, SensorKind kind,
                          std::string_view kind_name) {
  WAYMARK_TRY(row.CheckFieldCount(5, "timestamp, device, x, y, z"));
  WAYMARK_TRY_ASSIGN(const SensorTime time, row.Time(0));
  WAYMARK_TRY_ASSIGN(std::string sensor, ReadSensorId(row, sensors, kind, kind_name));
  WAYMARK_TRY_ASSIGN(const Eigen::Vector3d value, row.Vector(2, kind_name));
  return ImuRecord{time, std::move(sensor), value};
}

Result<TrajectoryRecord> ReadTrajectory(const KaptureRow& row, const KaptureSensors& sensors) {
  WAYMARK_TRY(row.CheckFieldCount(9, "timestamp, device, qw, qx, qy, qz, tx, ty, tz"));
  WAYMARK_TRY_ASSIGN(const SensorTime time, row.Time(0));
  WAYMARK_TRY_ASSIGN(std::string device, row.Name(1, "device id"));
  if (!sensors.kinds.contains(device) && !sensors.IsRig(device)) {
    return row.Wrong(ErrorCode::kCorrupt, "a sensor of sensors.txt or a rig of rigs.txt",
                     Quoted(device));
  }
  WAYMARK_TRY_ASSIGN(const Rigid3 device_from_world, row.Pose(2));
  return TrajectoryRecord{time, std::move(device), device_from_world};
}

/// Reads one table and sorts it by time; rows of one instant keep the file's order.
template <typename Record, typename ReadRow>
Result<std::vector<Record>> LoadRecords(const std::filesystem::path& path, ReadRow read_row) {
  std::vector<Record> records;
  WAYMARK_TRY(ForEachRow(path, [&](const KaptureRow& row) -> Result<void> {
    WAYMARK_TRY_ASSIGN(Record record, read_row(row));
    records.push_back(std::move(record));
    return {};
  }));
  std::stable_sort(records.begin(), records.end(),
                   [](const Record& a, const Record& b) { return a.time < b.time; });
  return records;
}

template <typename Record, typename ReadRow>
Result<std::vector<Record>> LoadOptionalRecords(const std::filesystem::path& path,
                                                ReadRow read_row) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return std::vector<Record>();
  return LoadRecords<Record>(path, read_row);
}

Result<std::vector<ImageRecord>> LoadImages(const std::filesystem::path& path,
                                            const KaptureSensors& sensors) {
  std::set<std::string> names;
  std::set<std::pair<SensorTime, std::string>> shots;
  return LoadRecords<ImageRecord>(path, [&](const KaptureRow& row) -> Result<ImageRecord> {
    WAYMARK_TRY_ASSIGN(ImageRecord image, ReadImage(row, sensors));
    if (!names.insert(image.name).second) {
      return row.Wrong(ErrorCode::kCorrupt, "each image once", Quoted(image.name) + " again");
    }
    if (!shots.emplace(image.time, image.camera).second) {
      return row.Wrong(ErrorCode::kCorrupt, "one image per camera and instant",
                       fmt::format("a second one, {}", Quoted(image.name)));
    }
    return image;
  });
}

Result<void> CheckImageFiles(const Experience& experience) {
  for (const ImageRecord& image : experience.images) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(experience.ImagePath(image), ignored)) continue;
    return MakeError(ErrorCode::kNotFound,
                     "{}: expected the image that records_camera.txt names, found no such file",
                     experience.ImagePath(image).string());
  }
  return {};
}

/// The folder's own name: "walk/" and "walk" are one experience.
Result<ExperienceId> ReadExperienceId(const std::filesystem::path& folder) {
  auto path = std::filesystem::absolute(folder).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  const std::string name = path.filename().string();
  if (IsExperienceIdText(name)) return ExperienceId(name);
  return MakeError(ErrorCode::kInvalidArgument,
                   "{}: expected a folder whose name can serve as the experience's id (printable, "
                   "not hidden), found {}",
                   folder.string(), Quoted(name));
}

Result<void> CheckIsKaptureFolder(const std::filesystem::path& folder) {
  const auto sensors = folder / "sensors" / "sensors.txt";
  std::error_code ignored;
  if (std::filesystem::exists(sensors, ignored)) return {};
  return MakeError(ErrorCode::kNotFound,
                   "{}: expected a kapture folder with sensors/sensors.txt, found none",
                   folder.string());
}

}  // namespace

Result<Experience> LoadKapture(const std::filesystem::path& folder) {
  WAYMARK_TRY(CheckIsKaptureFolder(folder));
  WAYMARK_TRY_ASSIGN(ExperienceId id, ReadExperienceId(folder));
  const auto tables = folder / "sensors";
  WAYMARK_TRY_ASSIGN(KaptureSensors sensors, internal::LoadKaptureSensors(tables));
  WAYMARK_TRY_ASSIGN(auto images, LoadImages(tables / "records_camera.txt", sensors));
  WAYMARK_TRY_ASSIGN(auto gnss, LoadOptionalRecords<GnssRecord>(
                                    tables / "records_gnss.txt",
                                    [&](const KaptureRow& row) { return ReadGnss(row, sensors); }));
  const auto load_imu = [&](std::string_view name, SensorKind kind) {
    return LoadOptionalRecords<ImuRecord>(
        tables / fmt::format("records_{}.txt", name),
        [&, kind](const KaptureRow& row) { return ReadImu(row, sensors, kind, name); });
  };
  WAYMARK_TRY_ASSIGN(auto accelerometer, load_imu("accelerometer", SensorKind::kAccelerometer));
  WAYMARK_TRY_ASSIGN(auto gyroscope, load_imu("gyroscope", SensorKind::kGyroscope));
  WAYMARK_TRY_ASSIGN(auto trajectory, LoadOptionalRecords<TrajectoryRecord>(
                                          tables / "trajectories.txt", [&](const KaptureRow& row) {
                                            return ReadTrajectory(row, sensors);
                                          }));
  Experience experience{
      std::move(id),        folder,          std::move(sensors.cameras), std::move(sensors.rigs),
      std::move(images),    std::move(gnss), std::move(accelerometer),   std::move(gyroscope),
      std::move(trajectory)};
  WAYMARK_TRY(CheckImageFiles(experience));
  return experience;
}

}  // namespace waymark::mapping
