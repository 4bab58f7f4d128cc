// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "examples/simulator/recording/simulation.h"

namespace waymark::simulator {

/// A world of one painted rectangle in the plane x = `distance_m`, facing the origin: its left edge
/// at y = half, its top at z = half.
inline City MakeBoard(const Canvas& canvas, double distance_m, double half_m) {
  City city{{}, {}, {}, {}, {}, {}};
  city.textures.emplace_back(canvas, TextureBorder::kClamp);
  city.mesh.AddQuad({distance_m, half_m, half_m}, {0, -2 * half_m, 0}, {0, 0, -2 * half_m},
                    {0, {}});
  return city;
}

/// Even light from everywhere that leaves colours nearly as painted at heights above 9 m.
inline Lighting EvenLight() {
  return {.to_sun = {0, 0, 1},
          .sun = {0, 0, 0},
          .sky = {1, 1, 1},
          .horizon = {0, 0, 0},
          .zenith = {0, 0, 0}};
}

/// A camera at the world's origin that looks along +x.
inline Rigid3 LookEast() {
  return {BodyFromCameraRotation(Angle::Degrees(0), Angle::Degrees(0)), Eigen::Vector3d::Zero()};
}

inline SimulationOptions QuickSimulation() {
  SimulationOptions options;
  MakeQuick(options);
  options.city.parallelism = options.parallelism;
  return options;
}

}  // namespace waymark::simulator
