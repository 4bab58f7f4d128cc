// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

#include "examples/simulator/world/facade_plan.h"
#include "examples/simulator/world/mesh.h"

namespace waymark::simulator {

/// The materials that houses share.
struct SharedMaterials {
  std::uint32_t side_wall;       ///< repeating texture, 4 m a side
  std::uint32_t roof;            ///< repeating texture, 4 m a side
  std::vector<Material> boards;  ///< wood, metal, stone, plants
  std::vector<Material> signs;   ///< boards with words
};

/// A straight building line along a street.
struct BuildingLine {
  Eigen::Vector2d start;      ///< its left end as seen from the street
  Eigen::Vector2d direction;  ///< unit, to the right as seen from the street
  double length_m;
};

/// Where one house stands and what its front looks like.
struct House {
  Eigen::Vector3d foot;    ///< left end of its front at the ground
  Eigen::Vector3d right;   ///< unit, along the front as seen from the street
  Eigen::Vector3d toward;  ///< unit, from the front to the street
  FacadePlan plan;
  std::uint64_t seed;
};

/// Fills a building line with row houses, wall to wall. With `kinds` > 0 they are copies of so many
/// houses in turn, the same in every row made with the same `pattern`.
std::vector<House> PlanRow(const BuildingLine& line, Random random, int kinds, Random pattern);

/// Adds a house: its front (with the texture `facade`) has recessed openings, a cornice, signs,
/// balconies and awnings; sides, back and roof are plain.
void BuildHouse(const House& house, std::uint32_t facade, const SharedMaterials& shared,
                Mesh& mesh);

}  // namespace waymark::simulator
