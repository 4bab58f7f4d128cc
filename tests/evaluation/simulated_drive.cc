// SPDX-License-Identifier: Apache-2.0
#include "tests/evaluation/simulated_drive.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "examples/simulator/sensors/inertial.h"
#include "examples/simulator/sensors/rig.h"
#include "examples/simulator/sensors/satellite.h"
#include "tests/evaluation/trajectory.h"

namespace waymark::evaluation {
namespace {

using simulator::Random;

constexpr double kControlS = 0.5;
constexpr double kLeadS = 10;  // a submap is a part of a longer drive: sensors run before and after
const GeoPoint kOrigin{Angle::Degrees(47.37), Angle::Degrees(8.54), 450};

/// Speed and turn of the path at a time.
struct Pace {
  double speed_mps;
  double turn_rad_per_s;
};

struct Plan {
  Route route;
  double duration_s;
  double speed_mps, side, phase, weave;

  Pace At(double t) const {
    const double wave = std::sin(2 * std::numbers::pi * t / 6 + phase);
    switch (route) {
      case Route::kStraight:
        return {speed_mps, 0.03 * weave * wave};
      case Route::kBend:
        return {speed_mps, side * 0.09 + 0.02 * weave * wave};
      case Route::kCorner: {
        const double in = (t - duration_s / 2) / 1.6;
        return {speed_mps * (1 - 0.45 * std::exp(-0.5 * in * in)),
                side * 0.39 * std::exp(-0.5 * in * in)};
      }
      case Route::kStopAndGo:
        return {speed_mps * (0.55 + 0.45 * std::cos(2 * std::numbers::pi * t / 9 + phase)),
                side * 0.04 + 0.03 * weave * wave};
      case Route::kTwoCameras:
        return {speed_mps, 0.06 * weave * wave};
      case Route::kOnFoot:
        return {1.3 + 0.3 * wave, 0.15 * std::sin(2 * std::numbers::pi * t / 11 + phase)};
    }
    return {0, 0};
  }
};

Plan MakePlan(Route route, Random& random) {
  const bool on_foot = route == Route::kOnFoot;
  const double speed_mps = route == Route::kCorner ? random.Uniform(6, 8) : random.Uniform(7, 11);
  return {.route = route,
          .duration_s = on_foot ? 30.0 : 10.0,
          .speed_mps = speed_mps,
          .side = random.Chance(0.5) ? 1.0 : -1.0,
          .phase = random.Uniform(0, 6.28),
          .weave = random.Uniform(0.7, 1.5)};
}

simulator::Motion MakeMotion(const Plan& plan, Random& random) {
  const bool on_foot = plan.route == Route::kOnFoot;
  std::vector<Eigen::Vector3d> path;
  std::vector<Eigen::Vector2d> gaze;
  Eigen::Vector3d place(0, 0, 1.6);
  double heading = random.Uniform(0, 6.28);
  const double begin_s = -kLeadS - 2 * kControlS;
  for (double t = begin_s; t < plan.duration_s + kLeadS + 3 * kControlS; t += kControlS) {
    path.push_back(place);
    gaze.emplace_back(on_foot ? 0.45 * std::sin(0.9 * t + plan.phase) : 0,
                      on_foot ? 0.08 * std::sin(0.7 * t) : 0);
    const Pace pace = plan.At(t + kControlS / 2);
    heading += 0.5 * kControlS * pace.turn_rad_per_s;
    place += kControlS * pace.speed_mps * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
    heading += 0.5 * kControlS * pace.turn_rad_per_s;
  }
  const double size = on_foot ? 2 : 1;
  const std::vector<simulator::Sway> sways{
      {on_foot ? 1.8 : 1.3, random.Uniform(0, 6), {0, 0, 0.012 * size}, 0, 0.004 * size, 0},
      {on_foot ? 0.9 : 0.8, random.Uniform(0, 6), {0, 0, 0}, 0.002 * size, 0, 0.005 * size}};
  return simulator::Motion({std::move(path), kControlS, begin_s},
                           {std::move(gaze), kControlS, begin_s}, sways);
}

/// House fronts on both sides of wherever the path leads, and the ground.
mapping::World MakeWorldAlong(const simulator::Motion& motion, double duration_s, double half_m,
                              Random& random) {
  mapping::World world;
  constexpr double kAfterM = 35;
  const auto road_at = [&](double t) {
    Rigid3 road = motion.WorldFromBody(std::min(t, duration_s));
    const double yaw = std::atan2((road.rotation() * Eigen::Vector3d::UnitX()).y(),
                                  (road.rotation() * Eigen::Vector3d::UnitX()).x());
    road = Rigid3(RotationFromVector({0, 0, yaw}), road.translation());
    return road;
  };
  double metres = 0;
  for (double t = 0.1; t < duration_s; t += 0.1) {
    metres += (road_at(t).translation() - road_at(t - 0.1).translation()).norm();
  }
  const int points = static_cast<int>(48 * (metres + kAfterM));
  for (int i = 0; i < points; ++i) {
    // Behind the end, the street goes on straight.
    const double at = random.Uniform(0, metres + kAfterM);
    const double t = duration_s * std::min(1.0, at / metres);
    const Rigid3 road = road_at(t);
    const double ahead = std::max(0.0, at - metres);
    Eigen::Vector3d place, normal;
    if (i % 5 == 4) {
      place = {ahead, random.Uniform(-half_m, half_m), 0};
      normal = {0, 0, 1};
    } else {
      const double side = i % 2 == 0 ? 1 : -1;
      place = {ahead, side * (half_m + random.Uniform(0, 1.5)), random.Uniform(0, 9)};
      normal = {0, -side, 0};
    }
    const Eigen::Vector3d ground(road.translation().x(), road.translation().y(), 0);
    world.points.push_back({ground + road.rotation() * place, road.rotation() * normal});
  }
  return world;
}

SensorTime At(double seconds) { return FromNanoseconds<SensorTime>(std::llround(seconds * 1e9)); }

void RecordSensors(const Random& random, double duration_s, const simulator::Motion& motion,
                   mapping::Experience& experience) {
  const simulator::Interval whole{-kLeadS, duration_s + kLeadS};
  for (const auto& sample : simulator::MeasureInertial(motion, whole, {}, random.Fork(2))) {
    experience.accelerometer.push_back({At(sample.time_s), "imu", sample.specific_force});
    experience.gyroscope.push_back({At(sample.time_s), "imu", sample.angular_velocity});
  }
  for (const auto& fix : simulator::MeasureSatellites(motion, whole, TangentPlane(kOrigin),
                                                      simulator::CarReceiver(), random.Fork(3))) {
    experience.gnss.push_back({At(fix.time_s), "gnss", fix.place, fix.sigma_m});
  }
}

}  // namespace

SimulatedDrive MakeDrive(Route route, std::uint64_t seed) {
  Random random = Random(seed).Fork(static_cast<std::uint64_t>(route));
  const Plan plan = MakePlan(route, random);
  simulator::Motion motion = MakeMotion(plan, random);
  const double half_m = random.Uniform(5.5, 8);
  mapping::World world = MakeWorldAlong(motion, plan.duration_s, half_m, random);
  SimulatedDrive drive{.route = route,
                       .motion = std::move(motion),
                       .world = std::move(world),
                       .body_from_camera = {},
                       .camera_of_image = {},
                       .seconds = {},
                       .true_poses = {},
                       .seen_from = {},
                       .experience = {.id = ExperienceId("drive")},
                       .seed = seed};
  const std::vector<double> yaws_deg =
      route == Route::kTwoCameras ? std::vector{0.0, 60.0} : std::vector{0.0};
  for (const double yaw_deg : yaws_deg) {
    drive.body_from_camera.emplace_back(
        simulator::BodyFromCameraRotation(Angle::Degrees(yaw_deg), Angle::Degrees(3)),
        Eigen::Vector3d(0.4, 0.1, 0.1));
  }
  const double period_s = route == Route::kOnFoot ? 0.75 : 0.33;
  for (int i = 0; i * period_s <= plan.duration_s; ++i) {
    for (std::uint32_t c = 0; c < drive.body_from_camera.size(); ++c) {
      drive.camera_of_image.push_back(c);
      drive.seconds.push_back(i * period_s + 0.011 * c);
      drive.true_poses.push_back(drive.motion.WorldFromBody(drive.seconds.back()) *
                                 drive.body_from_camera[c]);
    }
  }
  drive.seen_from = drive.true_poses;
  for (const char* sensor : {"imu", "gnss"}) {
    drive.experience.rigs.push_back({"rig", sensor, Rigid3()});
  }
  RecordSensors(random, plan.duration_s, drive.motion, drive.experience);
  return drive;
}

}  // namespace waymark::evaluation
