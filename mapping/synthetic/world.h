// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace waymark::mapping {

/// A point of a made-up world, seen only from its front.
struct SurfacePoint {
  Eigen::Vector3d position;
  Eigen::Vector3d normal;  ///< unit length, towards those who can see it
};

/// Metres, z up. Worlds that look like what the pipeline meets; the same seed gives the same world.
struct World {
  std::vector<SurfacePoint> points;
};

struct StreetOptions {
  double length_m = 60;  ///< along +y, from y = 0
  double width_m = 14;   ///< between the walls, which stand at x = +-width / 2
  double height_m = 10;  ///< of the walls
  double relief_m = 1;   ///< depth of balconies and doorways
  int points = 3000;     ///< 80 % on the walls, the rest on the ground
  std::uint64_t seed = 1;
};

/// Walls with relief on both sides of a straight street, and the ground.
World MakeStreet(const StreetOptions& options);

/// One flat wall in the plane y = 0, facing -y, centred on x = 0, standing on z = 0.
World MakeFacade(double width_m, double height_m, int points, std::uint64_t seed);

/// A square of walls around the origin, facing inwards, with a floor.
World MakeCourtyard(double side_m, double height_m, int points, std::uint64_t seed);

}  // namespace waymark::mapping
