// SPDX-License-Identifier: Apache-2.0
#include "examples/phone/walk.h"

#include <algorithm>

#include "mapping/experience/kapture.h"

namespace waymark::phone {
namespace {

using mapping::Experience;

DeviceTime ToDeviceTime(SensorTime time) {
  return FromNanoseconds<DeviceTime>(ToNanoseconds(time));
}

/// The camera's place in the rig that odometry speaks of; the rig itself when none is given.
Result<Transform<Device, Camera>> FindCameraMount(const Experience& experience,
                                                  const std::string& camera) {
  for (const auto& member : experience.rigs) {
    if (member.sensor == camera) {
      return Transform<Device, Camera>(member.sensor_from_rig.Inverse());
    }
  }
  return MakeError(ErrorCode::kInvalidArgument,
                   "{}: expected rigs.txt to say where camera {} sits, found no such line",
                   experience.folder.string(), camera);
}

std::vector<OdometrySample> ReadOdometry(const Experience& experience) {
  std::vector<OdometrySample> samples;
  for (const auto& record : experience.trajectory) {
    samples.push_back(
        {ToDeviceTime(record.time), Transform<Vo, Device>(record.device_from_world.Inverse())});
  }
  return samples;
}

/// The odometry at an instant; before the first and after the last sample, that sample.
Transform<Vo, Device> InterpolateOdometry(const std::vector<OdometrySample>& samples,
                                          DeviceTime time) {
  const auto after =
      std::lower_bound(samples.begin(), samples.end(), time,
                       [](const OdometrySample& s, DeviceTime t) { return s.time < t; });
  if (after == samples.begin()) return samples.front().vo_from_device;
  if (after == samples.end()) return samples.back().vo_from_device;
  const auto before = std::prev(after);
  const double fraction = Seconds(time - before->time) / Seconds(after->time - before->time);
  return Transform<Vo, Device>(
      Interpolate(before->vo_from_device.rigid(), after->vo_from_device.rigid(), fraction));
}

}  // namespace

Result<Walk> LoadWalk(const std::filesystem::path& folder) {
  WAYMARK_TRY_ASSIGN(const Experience experience, mapping::LoadKapture(folder));
  if (experience.cameras.size() != 1 || experience.images.empty()) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "{}: expected one camera with images, found {} cameras and {} images",
                     folder.string(), experience.cameras.size(), experience.images.size());
  }
  if (experience.trajectory.empty()) {
    return MakeError(ErrorCode::kInvalidArgument,
                     "{}: expected odometry in trajectories.txt, found none", folder.string());
  }
  const auto& sensor = experience.cameras.begin()->second;
  WAYMARK_TRY_ASSIGN(const auto device_from_camera, FindCameraMount(experience, sensor.id));
  Walk walk{.camera = sensor.model,
            .device_from_camera = device_from_camera,
            .odometry = ReadOdometry(experience),
            .frames = {}};
  auto gnss = experience.gnss.begin();
  std::optional<mapping::GnssRecord> last_gnss;
  for (const auto& image : experience.images) {
    while (gnss != experience.gnss.end() && gnss->time <= image.time) last_gnss = *gnss++;
    const DeviceTime time = ToDeviceTime(image.time);
    WalkFrame frame{.time = time,
                    .name = image.name,
                    .path = experience.ImagePath(image),
                    .vo_from_device = InterpolateOdometry(walk.odometry, time),
                    .gnss = std::nullopt};
    if (last_gnss) {
      frame.gnss = last_gnss->place;
      frame.gnss_sigma_m = last_gnss->sigma_m;
    }
    walk.frames.push_back(std::move(frame));
  }
  return walk;
}

}  // namespace waymark::phone
