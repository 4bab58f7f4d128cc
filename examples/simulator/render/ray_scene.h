// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "examples/simulator/world/mesh.h"
#include "mapping/base/result.h"

namespace waymark::simulator {

/// Where a ray first meets the world.
struct Hit {
  double distance;     ///< in lengths of the ray's direction, exact for the quad's plane
  std::uint32_t quad;  ///< position in the quads the scene was built from
};

/// Answers what rays meet. Immutable, thread-safe. The only door to Embree.
class RayScene {
 public:
  /// Errors: Unavailable when Embree cannot build the scene.
  static Result<RayScene> Create(std::span<const Quad> quads);

  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;
  ~RayScene();

  std::optional<Hit> FindFirstHit(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const;
  /// Whether anything stands within `distance_m` along a unit direction.
  bool IsBlocked(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                 double distance_m) const;

 private:
  struct Impl;

  explicit RayScene(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace waymark::simulator
