// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/facade_plan.h"

#include <algorithm>
#include <cmath>

namespace waymark::simulator {
namespace {

constexpr double kParapet = 0.7;

Storey PlanGroundFloor(double width_m, double ceiling_m, bool has_shop, Random& random) {
  Storey storey{0, ceiling_m, 0.25, ceiling_m - (has_shop ? 1.0 : 0.7), {}};
  const int slots = std::max(2, static_cast<int>(std::lround(width_m / random.Uniform(2.2, 3.6))));
  const double pitch = width_m / slots;
  const int door = random.Integer(0, slots - 1);
  for (int i = 0; i < slots; ++i) {
    const bool is_door = i == door;
    const double width =
        is_door ? std::min(1.3, pitch * 0.7) : pitch * random.Uniform(0.5, has_shop ? 0.86 : 0.65);
    const double centre = (i + 0.5) * pitch;
    storey.openings.push_back({centre - width / 2, centre + width / 2, is_door});
  }
  return storey;
}

}  // namespace

FacadePlan PlanFacade(double width_m, double height_m, Random random) {
  FacadePlan plan{width_m,
                  height_m,
                  static_cast<WallKind>(random.Integer(0, 3)),
                  random.Chance(0.55),
                  random.Chance(0.4),
                  {}};
  const double ground_ceiling = random.Uniform(3.3, 4.1);
  plan.storeys.push_back(PlanGroundFloor(width_m, ground_ceiling, plan.has_shop, random));
  const int upper = std::max(
      1, static_cast<int>((height_m - kParapet - ground_ceiling) / random.Uniform(2.8, 3.3)));
  const double storey_height = (height_m - kParapet - ground_ceiling) / upper;
  const int columns =
      std::max(2, static_cast<int>(std::lround(width_m / random.Uniform(1.9, 3.1))));
  const double pitch = width_m / columns;
  const double window_width = pitch * random.Uniform(0.42, 0.64);
  const double sill = random.Uniform(0.55, 0.9);
  const double head = storey_height - random.Uniform(0.4, 0.6);
  for (int i = 0; i < upper; ++i) {
    const double floor = ground_ceiling + i * storey_height;
    Storey storey{floor, floor + storey_height, floor + sill, floor + head, {}};
    for (int column = 0; column < columns; ++column) {
      if (random.Chance(0.1)) continue;  // walled up: no two houses repeat a pattern
      const double centre = (column + 0.5) * pitch + random.Uniform(-0.08, 0.08);
      storey.openings.push_back({centre - window_width / 2, centre + window_width / 2, false});
    }
    plan.storeys.push_back(std::move(storey));
  }
  return plan;
}

}  // namespace waymark::simulator
