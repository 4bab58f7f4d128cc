// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/world/mesh.h"

#include <cmath>
#include <numbers>

namespace waymark::simulator {

void Mesh::AddQuad(const Eigen::Vector3d& top_left, const Eigen::Vector3d& edge_right,
                   const Eigen::Vector3d& edge_down, const Material& material) {
  Add({top_left, edge_right, edge_down, material, NewSurface(), false});
}

void Mesh::AddBox(const Box& box, const Material& material) {
  const Eigen::Vector3d x =
      box.size.x() * Eigen::Vector3d(std::cos(box.yaw_rad), std::sin(box.yaw_rad), 0);
  const Eigen::Vector3d y =
      box.size.y() * Eigen::Vector3d(-std::sin(box.yaw_rad), std::cos(box.yaw_rad), 0);
  const Eigen::Vector3d down(0, 0, -box.size.z());
  const Eigen::Vector3d corner = box.base_centre - (x + y) / 2 - down;  // at the top, -x -y
  AddQuad(corner, x, down, material);
  AddQuad(corner + x, y, down, material);
  AddQuad(corner + x + y, -x, down, material);
  AddQuad(corner + y, -y, down, material);
  AddQuad(corner + y, x, -y, material);
}

void Mesh::AddColumn(const Eigen::Vector3d& base, double radius_m, double height_m, int sides,
                     const Material& material) {
  const Eigen::Vector3d up(0, 0, height_m);
  const auto rim = [&](int i) -> Eigen::Vector3d {
    const double angle = 2 * std::numbers::pi * i / sides;
    return base + up + radius_m * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
  };
  const std::uint32_t mantle = NewSurface();
  for (int i = 0; i < sides; ++i) {
    Material part = material;
    const double width = (material.area.u1 - material.area.u0) / sides;
    part.area.u0 = material.area.u0 + i * width;
    part.area.u1 = part.area.u0 + width;
    Add({rim(i), rim(i + 1) - rim(i), -up, part, mantle, false});
  }
}

void Mesh::Append(const Mesh& other) {
  for (Quad quad : other.quads_) {
    quad.surface += last_surface_;
    quads_.push_back(quad);
  }
  last_surface_ += other.last_surface_;
}

}  // namespace waymark::simulator
