// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <optional>
#include <vector>

#include "examples/simulator/render/lighting.h"
#include "examples/simulator/render/picture.h"
#include "examples/simulator/render/ray_scene.h"
#include "examples/simulator/world/city.h"
#include "mapping/geometry/camera_model.h"
#include "mapping/geometry/rigid3.h"

namespace waymark::simulator {

/// The directions that a camera's pixels see, computed once per camera. Immutable, thread-safe.
class ViewRays {
 public:
  explicit ViewRays(const CameraModel& camera);

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }
  /// Of a pixel's centre, with z = 1, camera axes.
  const Eigen::Vector3d& At(int column, int row) const {
    return directions_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_px_ + 1) +
                       static_cast<std::size_t>(column)];
  }

 private:
  int width_px_;
  int height_px_;
  std::vector<Eigen::Vector3d> directions_;  // one column and row more than the image
};

/// How finely pixels are sampled.
enum class Antialiasing {
  kNone,   ///< one ray per pixel; surfaces are still filtered
  kEdges,  ///< four more where surfaces or shadows meet
  kFull,   ///< four everywhere
};

/// Draws the city with whatever else stands in it under one light. Immutable, thread-safe; borrows
/// the city, which must outlive it.
class Renderer {
 public:
  /// Errors: those of RayScene.
  static Result<Renderer> Create(const City& city, const Mesh& traffic, const Lighting& lighting);

  const Lighting& lighting() const { return lighting_; }

  Radiance Render(const ViewRays& rays, const Rigid3& world_from_camera,
                  Antialiasing antialiasing = Antialiasing::kEdges) const;
  DepthImage RenderDepth(const ViewRays& rays, const Rigid3& world_from_camera) const;
  /// The point in the world that a ray first meets.
  std::optional<Eigen::Vector3d> FindSurface(const Eigen::Vector3d& origin,
                                             const Eigen::Vector3d& direction) const;

 private:
  static constexpr double kSunReach = 200;  // metres; nothing in a block throws a longer shadow

  /// A quad prepared for shading.
  struct Surface {
    Eigen::Vector3d corner;
    Eigen::Vector3d normal;    // unit
    Eigen::Vector3d to_right;  // dual basis: (x - corner) . to_right is 1 at the right edge
    Eigen::Vector3d to_down;
    Material material;
    std::uint32_t id;
  };
  /// A ray and its neighbours to the right and below, for the footprint.
  struct Beam {
    Eigen::Vector3d ray;
    Eigen::Vector3d right;
    Eigen::Vector3d below;
  };
  struct Shade {
    Eigen::Vector3f colour;
    std::uint32_t surface;  // with the shadow in its lowest bit: differs where an edge is seen
  };

  class Raster;

  Renderer(const City& city, RayScene scene, const Lighting& lighting)
      : city_(&city), scene_(std::move(scene)), lighting_(lighting) {}

  /// What a beam meets first beyond `start`, in lengths of its ray.
  Shade Trace(const Eigen::Vector3d& eye, const Beam& beam, double start = 0) const;
  /// Wet ground that would look like `dry`: darker, and it mirrors what stands on it.
  Eigen::Vector3f Wet(const Eigen::Vector3f& dry, const Eigen::Vector3d& eye, const Beam& beam,
                      double distance) const;
  /// Light that a sun before the camera scatters in the lens.
  void AddGlare(const ViewRays& rays, const Rigid3& world_from_camera, Radiance& image) const;
  Eigen::Vector3f Illuminate(const Eigen::Vector3d& place, const Eigen::Vector3d& normal,
                             bool is_in_shadow) const;
  /// Of all street lamps that are near and not hidden.
  Eigen::Vector3f LampLight(const Eigen::Vector3d& place, const Eigen::Vector3d& normal) const;
  Eigen::Vector3f SkyColour(const Eigen::Vector3d& direction) const;

  const City* city_;
  RayScene scene_;
  Lighting lighting_;
  std::vector<Surface> surfaces_;
};

}  // namespace waymark::simulator
