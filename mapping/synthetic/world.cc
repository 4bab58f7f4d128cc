// SPDX-License-Identifier: Apache-2.0
#include "mapping/synthetic/world.h"

#include "mapping/synthetic/random.h"

namespace waymark::mapping {

World MakeStreet(const StreetOptions& options) {
  internal::Random random(options.seed);
  World world;
  for (int i = 0; i < options.points; ++i) {
    const double y = random.Uniform(0, options.length_m);
    if (i % 5 == 4) {
      const double x = random.Uniform(-options.width_m / 2, options.width_m / 2);
      world.points.push_back({{x, y, 0}, {0, 0, 1}});
      continue;
    }
    const double side = i % 2 == 0 ? 1 : -1;
    const double x = options.width_m / 2 + random.Uniform(0, options.relief_m);
    world.points.push_back({{side * x, y, random.Uniform(0, options.height_m)}, {-side, 0, 0}});
  }
  return world;
}

World MakeFacade(double width_m, double height_m, int points, std::uint64_t seed) {
  internal::Random random(seed);
  World world;
  for (int i = 0; i < points; ++i) {
    const double x = random.Uniform(-width_m / 2, width_m / 2);
    world.points.push_back({{x, 0, random.Uniform(0, height_m)}, {0, -1, 0}});
  }
  return world;
}

World MakeCourtyard(double side_m, double height_m, int points, std::uint64_t seed) {
  internal::Random random(seed);
  World world;
  const double half = side_m / 2;
  for (int i = 0; i < points; ++i) {
    const double along = random.Uniform(-half, half);
    const double z = random.Uniform(0, height_m);
    switch (i % 5) {
      case 0:
        world.points.push_back({{half, along, z}, {-1, 0, 0}});
        break;
      case 1:
        world.points.push_back({{-half, along, z}, {1, 0, 0}});
        break;
      case 2:
        world.points.push_back({{along, half, z}, {0, -1, 0}});
        break;
      case 3:
        world.points.push_back({{along, -half, z}, {0, 1, 0}});
        break;
      default:
        world.points.push_back({{along, random.Uniform(-half, half), 0}, {0, 0, 1}});
    }
  }
  return world;
}

}  // namespace waymark::mapping
