// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <vector>

#include "examples/simulator/world/city.h"
#include "examples/simulator/world/house.h"

namespace waymark::simulator {

/// A stretch of street between two crossings.
struct StreetSegment {
  Eigen::Vector2d start;      ///< on the middle line
  Eigen::Vector2d direction;  ///< unit, along the street
  double length_m;
};

/// The town plan in lines; all in the order of CityOptions' grid.
struct StreetPlan {
  std::vector<Block> blocks;
  std::vector<StreetSegment> segments;
  std::vector<Eigen::Vector2d> crossings;    ///< their centres
  std::vector<BuildingLine> building_lines;  ///< of the blocks and of the ring around them
};

StreetPlan PlanStreets(const CityOptions& options);

/// Road, kerbs and pavements of one segment with the texture `street` of PaintStreet.
void BuildStreet(const StreetSegment& segment, const CityOptions& options, std::uint32_t street,
                 Mesh& mesh);
void BuildCrossing(const Eigen::Vector2d& centre, const CityOptions& options,
                   std::uint32_t crossing, Mesh& mesh);
/// Lamps, sign posts, bins, cabinets and bollards along both kerbs. The heads of the lamps.
std::vector<Eigen::Vector3d> BuildFurniture(const StreetSegment& segment,
                                            const CityOptions& options,
                                            const SharedMaterials& shared, Random random,
                                            Mesh& mesh);

}  // namespace waymark::simulator
