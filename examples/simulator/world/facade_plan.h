// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "examples/simulator/random.h"

namespace waymark::simulator {

/// A window or door, from left to right as seen from the street.
struct Opening {
  double left_m;
  double right_m;
  bool is_door = false;
};

/// One storey: its openings share sill and head. Heights are above the foot of the facade.
struct Storey {
  double floor_m;
  double ceiling_m;
  double sill_m;
  double head_m;
  std::vector<Opening> openings;  ///< left to right, disjoint
};

enum class WallKind { kBrick, kPlaster, kStone, kPlanks };

/// What a house shows to the street; painter and builder both follow it, so that painted frames
/// meet built recesses.
struct FacadePlan {
  double width_m;
  double height_m;
  WallKind wall;
  bool has_shop;
  bool has_balconies;
  std::vector<Storey> storeys;  ///< bottom to top; above the last is a parapet
};

FacadePlan PlanFacade(double width_m, double height_m, Random random);

}  // namespace waymark::simulator
