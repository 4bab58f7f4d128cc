// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "examples/simulator/motion/travel.h"
#include "examples/simulator/render/exposure.h"
#include "examples/simulator/sensors/inertial.h"
#include "examples/simulator/sensors/odometry.h"
#include "examples/simulator/sensors/rig.h"
#include "examples/simulator/sensors/satellite.h"
#include "mapping/base/time.h"
#include "mapping/experience/experience.h"
#include "mapping/geometry/geodesy.h"

namespace waymark::simulator {

/// One picture to be taken.
struct Shot {
  std::string name;    ///< below sensors/records_data
  std::size_t camera;  ///< position in Recording::cameras
  double time_s;       ///< of the motion
};

/// Everything one traveller brings home except the pictures themselves, and the truth about it.
struct Recording {
  std::string rig;  ///< "car" or "phone"
  std::vector<MountedCamera> cameras;
  Travel travel;
  SensorTime start;         ///< time 0 of the motion on the recorder's clock
  std::vector<Shot> shots;  ///< by time
  std::vector<InertialSample> inertial;
  std::vector<SatelliteFix> satellite;
  std::vector<OdometrySample> odometry;  ///< phones only

  Rigid3 WorldFromCamera(const Shot& shot) const;
  CameraMotion MotionOf(const Shot& shot) const;
};

/// What a car with cameras records.
struct CarOptions {
  int cameras = 3;  ///< [1, 4]: front, left, right, rear
  CameraOptions camera{.field_of_view = Angle::Degrees(75)};
  double spacing_m = 1.3;  ///< between pictures, [0.2, 20]
  DriveOptions drive;
  InertialOptions inertial;
  SatelliteOptions satellite = CarReceiver();

  Result<void> Validate() const;
};

/// What a walker's phone records.
struct PhoneOptions {
  CameraOptions camera;
  double keyframe_hz = 2;  ///< (0, 30]
  WalkOptions walk;
  InertialOptions inertial;
  SatelliteOptions satellite = PhoneReceiver();
  OdometryOptions odometry;

  Result<void> Validate() const;
};

/// Errors: InvalidArgument for options out of range.
Result<Recording> RecordDrive(const City& city, const TangentPlane& plane,
                              const CarOptions& options, Random random);
/// The `index`-th walker: even ones go the car's way, two of four walk on the inner pavement.
Result<Recording> RecordWalk(const City& city, const TangentPlane& plane, const CarOptions& car,
                             const PhoneOptions& options, int index, Random random);

/// The records as kapture has them; no truth in it.
mapping::Experience ToExperience(const Recording& recording);

}  // namespace waymark::simulator
