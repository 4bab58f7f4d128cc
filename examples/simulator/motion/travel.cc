// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/motion/travel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mapping/geometry/angle.h"

namespace waymark::simulator {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRoofHeight = 1.8;
constexpr double kEyeHeight = 1.6;
constexpr double kCornerRadius = 5;  // of the car's turns

Result<void> CheckRange(std::string_view name, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return MakeError(ErrorCode::kInvalidArgument, "{} must lie in [{}, {}], found {}", name, low,
                   high, value);
}

/// A spline through a route at nearly constant speed. One interval of slack at either end keeps
/// derivatives defined over [0, duration].
CubicSpline<3> FollowRoute(const Route& route, double start_m, double speed_mps, double duration_s,
                           double height_m, Random& random) {
  constexpr double kInterval = 0.5;
  const double phase = random.Uniform(0, 6.28);
  const double hesitation = 0.12 * speed_mps;  // metres ahead of and behind the mean
  std::vector<Vector3d> controls;
  const int count = static_cast<int>(std::ceil(duration_s / kInterval)) + 5;
  for (int i = 0; i < count; ++i) {
    const double time_s = (i - 2) * kInterval;
    const Vector2d place =
        route.At(start_m + speed_mps * time_s + hesitation * std::sin(0.5 * time_s + phase));
    controls.emplace_back(place.x(), place.y(), height_m);
  }
  return CubicSpline<3>(std::move(controls), kInterval, -2 * kInterval);
}

CubicSpline<2> LookAhead() { return CubicSpline<2>(std::vector(4, Vector2d(0, 0)), 1, -1); }

/// Looks mostly across the street, now and then ahead; `side` is +1 when the street is to the left.
CubicSpline<2> LookAround(double duration_s, double side, Random& random) {
  constexpr double kInterval = 2.2;
  std::vector<Vector2d> controls;
  const int count = static_cast<int>(std::ceil(duration_s / kInterval)) + 5;
  for (int i = 0; i < count; ++i) {
    const double yaw = random.Chance(0.15) ? random.Uniform(0, 30) : random.Uniform(50, 105);
    controls.emplace_back(Angle::Degrees(side * yaw).radians(),
                          Angle::Degrees(random.Uniform(-2, 12)).radians());
  }
  return CubicSpline<2>(std::move(controls), kInterval, -2 * kInterval);
}

/// Where on its route the drive starts; half of it lies before the first corner.
double DriveStart(const City& city, const DriveOptions& options) {
  const Block& block = city.blocks.front();
  return (block.high - block.low).x() / 2 + kCornerRadius - options.length_m / 2;
}

double RoadMiddle(const City& city) { return city.options.pavement_m + city.options.road_m / 2; }

Route DriveRoute(const City& city, double off_middle_m) {
  return Route(city.blocks.front(), RoadMiddle(city) + off_middle_m, kCornerRadius,
               Turning::kCounterClockwise);
}

}  // namespace

Result<void> DriveOptions::Validate() const {
  WAYMARK_TRY(CheckRange("drive: length_m", length_m, 5, 5000));
  return CheckRange("drive: speed_mps", speed_mps, 0.5, 20);
}

Result<void> WalkOptions::Validate() const {
  WAYMARK_TRY(CheckRange("walk: duration_s", duration_s, 1, 3600));
  return CheckRange("walk: speed_mps", speed_mps, 0.1, 3);
}

Travel MakeDrive(const City& city, const DriveOptions& options, Random random) {
  const Route route = DriveRoute(city, random.Uniform(0, 0.8));
  const double start_m = DriveStart(city, options) + random.Uniform(-0.6, 0.6);
  const double duration_s = options.length_m / options.speed_mps;
  const double pitch = Angle::Degrees(0.25).radians();
  std::vector<Sway> sways{{1.3, random.Uniform(0, 6.28), {0, 0, 0.006}, 0, pitch, 0},
                          {0.7, random.Uniform(0, 6.28), {0, 0, 0.004}, 0, 0, 1.4 * pitch}};
  return {Motion(FollowRoute(route, start_m, options.speed_mps, duration_s, kRoofHeight, random),
                 LookAhead(), std::move(sways)),
          duration_s};
}

Travel MakeWalk(const City& city, const DriveOptions& drive, const WalkOptions& options,
                Pavement pavement, Turning turning, Random random) {
  const double from_wall = 0.5 * city.options.pavement_m + random.Uniform(-0.08, 0.08);
  const bool is_inner = pavement == Pavement::kInner;
  const double distance = is_inner ? from_wall : city.options.StreetWidth() - from_wall;
  const Route route(city.blocks.front(), distance, std::min(distance, kCornerRadius), turning);
  const bool is_along = turning == Turning::kCounterClockwise;
  const double begin = DriveStart(city, drive);
  const Vector2d place = DriveRoute(city, 0).At(is_along ? begin : begin + drive.length_m);
  const double start_m = route.FindNearest(place) + random.Uniform(1, 3);
  // Going round counter-clockwise the block is to the left, so the street is on the inner
  // pavement's right.
  const double side = is_along == is_inner ? -1 : 1;
  const double degree = Angle::Degrees(1).radians();
  const double step_hz = random.Uniform(1.6, 1.9);
  const auto phase = [&] { return random.Uniform(0, 6.28); };
  std::vector<Sway> sways{{step_hz, phase(), {0, 0, 0.015}, 0, 0.5 * degree, 0},
                          {step_hz / 2, phase(), {0.015, 0.015, 0}, 0.9 * degree, 0, 0.8 * degree},
                          {0.23, phase(), {0, 0, 0}, 1.5 * degree, 0.8 * degree, 1.2 * degree}};
  CubicSpline<3> path = FollowRoute(route, start_m, options.speed_mps, options.duration_s,
                                    kKerbHeight + kEyeHeight, random);
  return {Motion(std::move(path), LookAround(options.duration_s, side, random), std::move(sways)),
          options.duration_s};
}

}  // namespace waymark::simulator
