// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <vector>

#include "examples/simulator/render/texture.h"
#include "examples/simulator/world/mesh.h"
#include "mapping/base/parallel.h"
#include "mapping/base/result.h"

namespace waymark::simulator {

/// The town plan: a grid of blocks with streets on all sides, closed by a ring of houses.
struct CityOptions {
  int blocks_east = 1;        ///< [1, 8]
  int blocks_north = 1;       ///< [1, 8]
  double block_east_m = 52;   ///< side of a block, [20, 200]
  double block_north_m = 40;  ///< [20, 200]
  double road_m = 8;          ///< kerb to kerb, [4, 20]
  double pavement_m = 3;      ///< each side, [1.5, 8]
  double texels_per_m = 90;   ///< of house fronts, [10, 200]; 90 is one texel per pixel at 5.5 m
  int house_kinds = 0;        ///< [0, 100]; 0: no house is like another; else rows repeat so many
  std::uint64_t seed = 1;
  Parallelism parallelism;

  double StreetWidth() const { return road_m + 2 * pavement_m; }
  Result<void> Validate() const;
};

/// A horizontal rectangle that streets run around.
struct Block {
  Eigen::Vector2d low;   ///< south-west corner
  Eigen::Vector2d high;  ///< north-east corner
};

/// The height of pavements above roads, whose surface is z = 0.
inline constexpr double kKerbHeight = 0.12;

/// Everything that does not move: geometry in east, north, up with the origin at the south-west
/// corner of the first block. Immutable, thread-safe.
struct City {
  CityOptions options;
  std::vector<Block> blocks;  ///< row by row from the south-west
  Mesh mesh;
  std::vector<Texture> textures;
  std::vector<Material> paints;             ///< plain materials of vehicles and clothes
  std::vector<Material> dark_paints;        ///< of tyres, car windows, trousers
  std::vector<Eigen::Vector3d> lamps = {};  ///< the heads of street lamps
};

/// Lays out, paints and builds a city; deterministic in the options, whatever the thread count.
/// Errors: InvalidArgument for options out of range.
Result<City> BuildCity(const CityOptions& options);

}  // namespace waymark::simulator
