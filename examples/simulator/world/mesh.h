// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <vector>

namespace waymark::simulator {

/// Part of a texture: from its top left to its bottom right corner, v downwards.
struct TextureArea {
  double u0 = 0;
  double v0 = 0;
  double u1 = 1;
  double v1 = 1;
};

/// What a surface is made of.
struct Material {
  std::uint32_t texture;  ///< position in City::textures
  TextureArea area;
};

/// A flat parallelogram in the world. Its texture stands upright when corner + edge_right runs to
/// the viewer's right and edge_down downwards; visible from both sides.
struct Quad {
  Eigen::Vector3d top_left;
  Eigen::Vector3d edge_right;
  Eigen::Vector3d edge_down;
  Material material;
  std::uint32_t surface;     ///< equal for quads between which no edge is to be seen
  bool is_triangle = false;  ///< only the half at top_left
};

/// A box that stands on the ground plane of its own axes.
struct Box {
  Eigen::Vector3d base_centre;
  Eigen::Vector3d size;  ///< along its x, y (horizontal) and z (up), metres
  double yaw_rad = 0;    ///< of its x axis, counter-clockwise from east
};

/// Collects quads. Thread-compatible.
class Mesh {
 public:
  const std::vector<Quad>& quads() const { return quads_; }

  /// A number for quads that form one surface.
  std::uint32_t NewSurface() { return ++last_surface_; }
  void Add(const Quad& quad) { quads_.push_back(quad); }
  /// A quad that is a surface of its own.
  void AddQuad(const Eigen::Vector3d& top_left, const Eigen::Vector3d& edge_right,
               const Eigen::Vector3d& edge_down, const Material& material);
  /// Four sides and the top, all showing the same area.
  void AddBox(const Box& box, const Material& material);
  /// An upright prism with this many sides, open at the top.
  void AddColumn(const Eigen::Vector3d& base, double radius_m, double height_m, int sides,
                 const Material& material);
  /// Everything of another mesh; surfaces stay apart.
  void Append(const Mesh& other);

 private:
  std::vector<Quad> quads_;
  std::uint32_t last_surface_ = 0;
};

}  // namespace waymark::simulator
