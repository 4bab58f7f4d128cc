// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mapping/base/id.h"
#include "mapping/base/time.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::mapping {

/// A camera as its recorder describes it; intrinsics may be approximate or unknown.
struct CameraSensor {
  std::string id;
  CameraModel model;            ///< a guess when `has_known_focal` is false
  bool has_known_focal = true;  ///< false: UNKNOWN_CAMERA in kapture, focal guessed
};

struct ImageRecord {
  SensorTime time;
  std::string camera;  ///< CameraSensor::id
  std::string name;    ///< path below sensors/records_data, unique in its experience
};

struct GnssRecord {
  SensorTime time;
  std::string sensor;
  GeoPoint place;
  double sigma_m;  ///< > 0, one axis
};

/// One accelerometer (specific force, m/s^2) or gyroscope (rad/s) sample, in the sensor's axes.
struct ImuRecord {
  SensorTime time;
  std::string sensor;
  Eigen::Vector3d value;
};

/// Where a sensor sits in its rig.
struct RigMember {
  std::string rig;
  std::string sensor;
  Rigid3 sensor_from_rig;
};

/// A pose recorded by the vehicle itself (INS or odometry), in a world of its own.
struct TrajectoryRecord {
  SensorTime time;
  std::string device;
  Rigid3 device_from_world;
};

/// One recording of one vehicle: what a kapture folder holds, images named but not loaded.
/// Records are sorted by time. Immutable once read.
struct Experience {
  ExperienceId id;
  std::filesystem::path folder = {};
  std::map<std::string, CameraSensor> cameras = {};
  std::vector<RigMember> rigs = {};
  std::vector<ImageRecord> images = {};
  std::vector<GnssRecord> gnss = {};
  std::vector<ImuRecord> accelerometer = {};
  std::vector<ImuRecord> gyroscope = {};
  std::vector<TrajectoryRecord> trajectory = {};

  std::filesystem::path ImagePath(const ImageRecord& image) const {
    return folder / "sensors" / "records_data" / image.name;
  }
};

}  // namespace waymark::mapping
