// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::mapping {

/// One sighting of a point by a posed camera. Borrows the camera.
struct Sighting {
  const CameraModel* camera;
  Rigid3 world_from_camera;
  Eigen::Vector2d pixel_px;
};

struct TriangulationOptions {
  double max_error_px = 4;
  double min_angle_rad = 0.026;  ///< between the widest pair of rays
};

struct TriangulatedPoint {
  Eigen::Vector3d position_in_world;
  std::vector<std::uint32_t> inliers;  ///< indices of the sightings, ascending, at least two
};

/// Finds the point that most sightings agree on: a hypothesis from every pair of rays (from a
/// spread subset when there are many), then least squares over those that agree.
/// nullopt: no two rays meet in front of their cameras at a sufficient angle.
std::optional<TriangulatedPoint> Triangulate(std::span<const Sighting> sightings,
                                             const TriangulationOptions& options);

/// The widest angle between rays from the point to the chosen sightings' cameras.
double WidestAngle(const Eigen::Vector3d& point_in_world, std::span<const Sighting> sightings,
                   std::span<const std::uint32_t> chosen);

/// Reprojection error, infinite for a point that is not in front of the camera.
double ReprojectionErrorPx(const Eigen::Vector3d& point_in_world, const Sighting& sighting);

}  // namespace waymark::mapping
