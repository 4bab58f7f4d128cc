// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/recording/recording.h"

#include <algorithm>
#include <cmath>

namespace waymark::simulator {
namespace {

constexpr const char* kGnss = "gps0";
constexpr const char* kAccelerometer = "acc0";
constexpr const char* kGyroscope = "gyro0";

/// Recorders were not started together, and none of them started its clock at 0.
SensorTime AnyStart(Random& random) {
  return FromNanoseconds<SensorTime>(std::int64_t{1'000'000'000} * random.Integer(100, 90'000));
}

/// Cameras on cars have lenses and pixels that gather more light.
constexpr double kCarShutter = 0.15;

void SortByTime(std::vector<Shot>& shots) {
  std::stable_sort(shots.begin(), shots.end(),
                   [](const Shot& a, const Shot& b) { return a.time_s < b.time_s; });
}

}  // namespace

Rigid3 Recording::WorldFromCamera(const Shot& shot) const {
  return travel.motion.WorldFromBody(shot.time_s) * cameras[shot.camera].body_from_camera;
}

CameraMotion Recording::MotionOf(const Shot& shot) const {
  const Motion& motion = travel.motion;
  const Rigid3& body_from_camera = cameras[shot.camera].body_from_camera;
  const Eigen::Vector3d turning = motion.AngularVelocityInBody(shot.time_s);
  const Eigen::Vector3d lever = turning.cross(body_from_camera.translation());
  const Eigen::Quaterniond world_from_body = motion.WorldFromBody(shot.time_s).rotation();
  return {motion.VelocityInWorld(shot.time_s) + world_from_body * lever,
          body_from_camera.rotation().conjugate() * turning, odometry.empty() ? kCarShutter : 1};
}

Result<void> CarOptions::Validate() const {
  WAYMARK_TRY(camera.Validate());
  WAYMARK_TRY(drive.Validate());
  if (spacing_m >= 0.2 && spacing_m <= 20) return {};
  return MakeError(ErrorCode::kInvalidArgument, "car: spacing_m must lie in [0.2, 20], found {}",
                   spacing_m);
}

Result<void> PhoneOptions::Validate() const {
  WAYMARK_TRY(camera.Validate());
  WAYMARK_TRY(walk.Validate());
  if (keyframe_hz > 0 && keyframe_hz <= 30) return {};
  return MakeError(ErrorCode::kInvalidArgument, "phone: keyframe_hz must lie in (0, 30], found {}",
                   keyframe_hz);
}

Result<Recording> RecordDrive(const City& city, const TangentPlane& plane,
                              const CarOptions& options, Random random) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY_ASSIGN(std::vector<MountedCamera> cameras,
                     MakeCarRig(options.cameras, options.camera));
  Recording recording{"car",
                      std::move(cameras),
                      MakeDrive(city, options.drive, random.Fork(1)),
                      AnyStart(random),
                      {},
                      {},
                      {},
                      {}};
  const double period_s = options.spacing_m / options.drive.speed_mps;
  const Interval whole{0, recording.travel.duration_s};
  for (std::size_t camera = 0; camera < recording.cameras.size(); ++camera) {
    const MountedCamera& mounted = recording.cameras[camera];
    for (int i = 0; i * period_s + mounted.delay_s <= whole.last_s; ++i) {
      recording.shots.push_back(
          {fmt::format("{}/{:06}", mounted.id, i), camera, i * period_s + mounted.delay_s});
    }
  }
  SortByTime(recording.shots);
  const Motion& motion = recording.travel.motion;
  recording.inertial = MeasureInertial(motion, whole, options.inertial, random.Fork(2));
  recording.satellite = MeasureSatellites(motion, whole, plane, options.satellite, random.Fork(3));
  return recording;
}

Result<Recording> RecordWalk(const City& city, const TangentPlane& plane, const CarOptions& car,
                             const PhoneOptions& options, int index, Random random) {
  WAYMARK_TRY(options.Validate());
  WAYMARK_TRY_ASSIGN(std::vector<MountedCamera> cameras, MakePhoneRig(options.camera));
  const Pavement pavement = index / 2 % 2 == 0 ? Pavement::kInner : Pavement::kOuter;
  const Turning turning = index % 2 == 0 ? Turning::kCounterClockwise : Turning::kClockwise;
  Recording recording{"phone",
                      std::move(cameras),
                      MakeWalk(city, car.drive, options.walk, pavement, turning, random.Fork(1)),
                      AnyStart(random),
                      {},
                      {},
                      {},
                      {}};
  const Interval whole{0, recording.travel.duration_s};
  for (int i = 0; i / options.keyframe_hz < whole.last_s; ++i) {
    recording.shots.push_back({fmt::format("{:06}", i), 0, i / options.keyframe_hz});
  }
  const Motion& motion = recording.travel.motion;
  recording.inertial = MeasureInertial(motion, whole, options.inertial, random.Fork(2));
  recording.satellite = MeasureSatellites(motion, whole, plane, options.satellite, random.Fork(3));
  recording.odometry = SimulateOdometry(motion, whole, options.odometry, random.Fork(4));
  return recording;
}

mapping::Experience ToExperience(const Recording& recording) {
  mapping::Experience experience{ExperienceId(recording.rig), {}, {}, {}, {}, {}, {}, {}, {}};
  const auto at = [&](double time_s) {
    return recording.start + std::chrono::nanoseconds(std::llround(time_s * 1e9));
  };
  for (const MountedCamera& camera : recording.cameras) {
    experience.cameras.emplace(camera.id, mapping::CameraSensor{camera.id, camera.model, true});
    experience.rigs.push_back({recording.rig, camera.id, camera.body_from_camera.Inverse()});
  }
  for (const char* sensor : {kGnss, kAccelerometer, kGyroscope}) {
    experience.rigs.push_back({recording.rig, sensor, Rigid3()});
  }
  for (const Shot& shot : recording.shots) {
    experience.images.push_back({at(shot.time_s), recording.cameras[shot.camera].id, shot.name});
  }
  for (const SatelliteFix& fix : recording.satellite) {
    experience.gnss.push_back({at(fix.time_s), kGnss, fix.place, fix.sigma_m});
  }
  for (const InertialSample& sample : recording.inertial) {
    experience.accelerometer.push_back({at(sample.time_s), kAccelerometer, sample.specific_force});
    experience.gyroscope.push_back({at(sample.time_s), kGyroscope, sample.angular_velocity});
  }
  for (const OdometrySample& sample : recording.odometry) {
    experience.trajectory.push_back(
        {at(sample.time_s), recording.rig, sample.vo_from_device.rigid().Inverse()});
  }
  return experience;
}

}  // namespace waymark::simulator
