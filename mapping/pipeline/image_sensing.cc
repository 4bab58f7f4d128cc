// SPDX-License-Identifier: Apache-2.0
#include "mapping/pipeline/internal/image_sensing.h"

#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "mapping/pipeline/internal/gnss_track.h"
#include "mapping/pipeline/internal/inertial.h"
#include "mapping/pipeline/internal/levelling.h"

namespace waymark::mapping {
namespace {

/// The records of the sensor with most of them.
template <typename Record>
std::vector<Record> RecordsOfMainSensor(const std::vector<Record>& records) {
  std::map<std::string, std::size_t> counts;
  for (const Record& record : records) ++counts[record.sensor];
  const std::string* main = nullptr;
  for (const auto& [sensor, count] : counts) {
    if (main == nullptr || count > counts[*main]) main = &sensor;
  }
  std::vector<Record> chosen;
  for (const Record& record : records) {
    if (record.sensor == *main) chosen.push_back(record);
  }
  return chosen;
}

/// One sensor of the vehicle and where each camera sits relative to it.
template <typename Record>
struct Mounted {
  std::vector<Record> records;
  std::vector<std::optional<Rigid3>> camera_from_sensor;  ///< by camera
};

template <typename Record>
Mounted<Record> Mount(const Experience& experience, const std::vector<Record>& records,
                      const std::vector<std::string>& cameras) {
  Mounted<Record> mounted{RecordsOfMainSensor(records), {}};
  for (const std::string& camera : cameras) {
    mounted.camera_from_sensor.push_back(
        records.empty()
            ? std::nullopt
            : FindSensorFromSensor(experience.rigs, camera, mounted.records.front().sensor));
  }
  return mounted;
}

/// Gyroscope records in the accelerometer's axes; none where their mounting is not known.
std::vector<ImuRecord> TurnIntoAxes(const Experience& experience,
                                    const Mounted<ImuRecord>& gyroscope,
                                    const Mounted<ImuRecord>& accelerometer) {
  if (gyroscope.records.empty() || accelerometer.records.empty()) return {};
  const auto mount = FindSensorFromSensor(experience.rigs, accelerometer.records.front().sensor,
                                          gyroscope.records.front().sensor);
  if (!mount) return {};
  std::vector<ImuRecord> turned = gyroscope.records;
  for (ImuRecord& record : turned) record.value = mount->rotation() * record.value;
  return turned;
}

void SensePosition(const GnssTrack& track, const std::optional<Rigid3>& camera_from_antenna,
                   const TangentPlane& map, IndexedImage& image) {
  const std::optional<GnssPosition> antenna = track.FindPosition(image.time);
  if (!antenna) return;
  Eigen::Vector3d position = antenna->position.coordinates();
  image.gnss_sigma_m = antenna->sigma_m;
  if (camera_from_antenna) {
    const Eigen::Vector3d camera_in_camera_axes = -camera_from_antenna->translation();
    const double above_m = image.up_in_camera ? image.up_in_camera->dot(camera_in_camera_axes) : 0;
    const double aside_m =
        std::sqrt(std::max(0.0, camera_in_camera_axes.squaredNorm() - above_m * above_m));
    position.z() += above_m;
    image.gnss_sigma_m = std::hypot(image.gnss_sigma_m, aside_m);
  }
  image.gnss = map.ToGeo(Point<Map>(position));
}

void SenseRotation(const Mounted<ImuRecord>& gyroscope, const IndexedImage& next,
                   IndexedImage& image) {
  const auto& camera_from_gyroscope = gyroscope.camera_from_sensor[image.camera];
  if (!camera_from_gyroscope) return;
  const auto turned = IntegrateRotation(gyroscope.records, image.time, next.time);
  if (!turned) return;
  const Eigen::Quaterniond& mount = camera_from_gyroscope->rotation();
  image.next_from_this = (mount * *turned * mount.conjugate()).normalized();
}

}  // namespace

void SenseImages(const Experience& experience, const TangentPlane& map,
                 std::vector<IndexedImage>& images) {
  std::vector<std::string> cameras;
  for (const auto& [id, camera] : experience.cameras) cameras.push_back(id);
  const auto gnss = Mount(experience, experience.gnss, cameras);
  const auto accelerometer = Mount(experience, experience.accelerometer, cameras);
  const auto gyroscope = Mount(experience, experience.gyroscope, cameras);
  const GnssTrack track(gnss.records, map, {});

  const Levelling levelling(accelerometer.records,
                            TurnIntoAxes(experience, gyroscope, accelerometer), track.fixes(), {});
  for (IndexedImage& image : images) {
    if (const auto& mount = accelerometer.camera_from_sensor[image.camera]) {
      auto up = levelling.FindUp(image.time);
      if (!up) up = FindUpAtRest(accelerometer.records, gyroscope.records, image.time);
      if (up) image.up_in_camera = (mount->rotation() * *up).normalized();
    }
    SensePosition(track, gnss.camera_from_sensor[image.camera], map, image);
  }
  std::map<std::uint32_t, IndexedImage*> last_of_camera;
  for (IndexedImage& image : images) {
    IndexedImage*& last = last_of_camera[image.camera];
    if (last != nullptr) SenseRotation(gyroscope, image, *last);
    last = &image;
  }
}

}  // namespace waymark::mapping
