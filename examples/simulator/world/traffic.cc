// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/traffic.h"

#include <cmath>
#include <numbers>

#include "examples/simulator/world/street.h"

namespace waymark::simulator {
namespace {

using Eigen::Vector3d;

const Material& AnyOf(const std::vector<Material>& materials, Random& random) {
  return materials[random.Bits() % materials.size()];
}

void AddCar(const City& city, const Vector3d& place, double yaw_rad, Random& random, Mesh& mesh) {
  const Material& paint = AnyOf(city.paints, random);
  const Material& dark = AnyOf(city.dark_paints, random);
  const Vector3d forward(std::cos(yaw_rad), std::sin(yaw_rad), 0);
  const Vector3d left(-std::sin(yaw_rad), std::cos(yaw_rad), 0);
  const double length = random.Uniform(3.7, 4.7);
  const Vector3d up(0, 0, 1);
  mesh.AddBox({place + 0.3 * up, {length, 1.7, 0.65}, yaw_rad}, paint);
  mesh.AddBox({place + 0.95 * up - 0.2 * forward, {0.52 * length, 1.5, 0.5}, yaw_rad}, dark);
  mesh.AddBox({place + 1.45 * up - 0.2 * forward, {0.44 * length, 1.4, 0.06}, yaw_rad}, paint);
  for (const double along : {-0.3 * length, 0.3 * length}) {
    for (const double side : {-0.78, 0.78}) {
      mesh.AddBox({place + along * forward + side * left, {0.62, 0.2, 0.6}, yaw_rad}, dark);
    }
  }
}

void AddPerson(const City& city, const Vector3d& place, Random& random, Mesh& mesh) {
  const double height = random.Uniform(1.55, 1.9);
  const double yaw = random.Uniform(0, std::numbers::pi);
  const Vector3d up(0, 0, 1);
  mesh.AddBox({place, {0.3, 0.22, 0.47 * height}, yaw}, AnyOf(city.dark_paints, random));
  mesh.AddBox({place + 0.47 * height * up, {0.46, 0.26, 0.37 * height}, yaw},
              AnyOf(city.paints, random));
  mesh.AddColumn(place + 0.85 * height * up, 0.1, 0.15 * height, 8, AnyOf(city.paints, random));
}

}  // namespace

Result<void> TrafficOptions::Validate() const {
  if (parked_share >= 0 && parked_share <= 1 && people_per_100_m >= 0 && people_per_100_m <= 1000) {
    return {};
  }
  return MakeError(ErrorCode::kInvalidArgument,
                   "traffic: expected a share in [0, 1] and up to 1000 people per 100 m, found {} "
                   "and {}",
                   parked_share, people_per_100_m);
}

Mesh MakeTraffic(const City& city, const TrafficOptions& options, Random random) {
  constexpr double kParkingPlace = 5.6;
  Mesh mesh;
  const double car_offset = city.options.road_m / 2 - 1.1;
  for (const StreetSegment& segment : PlanStreets(city.options).segments) {
    const Vector3d along(segment.direction.x(), segment.direction.y(), 0);
    const Vector3d left(-along.y(), along.x(), 0);
    const Vector3d start(segment.start.x(), segment.start.y(), 0);
    const double yaw = std::atan2(along.y(), along.x());
    for (const double side : {1.0, -1.0}) {
      for (double at = 6.5; at < segment.length_m - 6; at += kParkingPlace) {
        if (!random.Chance(options.parked_share)) continue;
        AddCar(city, start + at * along + side * car_offset * left, yaw, random, mesh);
      }
      const double people = options.people_per_100_m * segment.length_m / 200;
      const int count = static_cast<int>(std::lround(people));
      for (int i = 0; i < count; ++i) {
        const double offset = city.options.road_m / 2 + random.Uniform(0.25, 0.75);
        AddPerson(city,
                  start + random.Uniform(1, segment.length_m - 1) * along + side * offset * left +
                      Vector3d(0, 0, kKerbHeight),
                  random, mesh);
      }
    }
  }
  return mesh;
}

}  // namespace waymark::simulator
