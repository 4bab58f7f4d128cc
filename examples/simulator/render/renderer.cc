// SPDX-License-Identifier: Apache-2.0
#include "examples/simulator/render/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace waymark::simulator {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr std::uint32_t kSkySurface = 0;
constexpr double kShadowReach = 200;   // metres; nothing in a city block throws a longer one
constexpr double kShadowLift = 0.004;  // metres off the surface, above float error at 200 m

/// Where a neighbouring ray meets the plane of the surface; itself where it runs away from it.
Vector3d MeetPlane(const Vector3d& eye, const Vector3d& ray, const Vector3d& normal,
                   double plane_distance, const Vector3d& fallback) {
  const double slope = normal.dot(ray);
  if (std::abs(slope) < 1e-9 * ray.norm()) return fallback;
  const double distance = plane_distance / slope;
  return distance > 0 ? Vector3d(eye + distance * ray) : fallback;
}

/// Display values carry gamma 2.2, so light multiplies them by its 2.2th root.
float Display(float linear) { return std::pow(std::max(linear, 0.0F), 1 / 2.2F); }

}  // namespace

ViewRays::ViewRays(const CameraModel& camera)
    : width_px_(camera.width_px()), height_px_(camera.height_px()) {
  directions_.reserve(static_cast<std::size_t>(width_px_ + 1) *
                      static_cast<std::size_t>(height_px_ + 1));
  for (int row = 0; row <= height_px_; ++row) {
    for (int column = 0; column <= width_px_; ++column) {
      const Eigen::Vector2d normalized = camera.Normalize({column + 0.5, row + 0.5});
      directions_.emplace_back(normalized.x(), normalized.y(), 1);
    }
  }
}

Result<Renderer> Renderer::Create(const City& city, const Mesh& traffic, const Lighting& lighting) {
  Mesh all = city.mesh;
  all.Append(traffic);
  WAYMARK_TRY_ASSIGN(RayScene scene, RayScene::Create(all.quads()));
  Renderer renderer(city, std::move(scene), lighting);
  renderer.surfaces_.reserve(all.quads().size());
  for (const Quad& quad : all.quads()) {
    const Vector3d normal = quad.edge_down.cross(quad.edge_right);
    const double area = normal.norm();
    const Vector3d unit = normal / area;
    renderer.surfaces_.push_back({quad.top_left, unit, quad.edge_down.cross(unit) / -area,
                                  quad.edge_right.cross(unit) / area, quad.material, quad.surface});
  }
  return renderer;
}

Vector3f Renderer::SkyColour(const Vector3d& direction) const {
  const Vector3d unit = direction.normalized();
  const auto height = static_cast<float>(std::sqrt(std::clamp(unit.z(), 0.0, 1.0)));
  Vector3f colour = lighting_.horizon + height * (lighting_.zenith - lighting_.horizon);
  if (lighting_.clouds > 0 && unit.z() > 0.02) {
    const double x = unit.x() / (unit.z() + 0.2);
    const double y = unit.y() / (unit.z() + 0.2);
    const double wisps = std::sin(1.9 * x + 1.3 * std::sin(1.1 * y)) *
                         std::sin(2.3 * y + 1.7 * std::sin(0.9 * x + 0.5));
    colour += lighting_.clouds * static_cast<float>(std::max(0.0, wisps)) *
              (Vector3f(245, 245, 245) - colour);
  }
  return colour;
}

Vector3f Renderer::Illuminate(const Vector3d& place, const Vector3d& normal,
                              bool is_in_shadow) const {
  // Less sky is seen from walls than from the ground, and less from low down in a street.
  const double openness = 0.72 + 0.28 * normal.z();
  const double canyon = 0.62 + 0.38 * std::clamp(place.z() / 9, 0.0, 1.0);
  Vector3f light = static_cast<float>(openness * canyon) * lighting_.sky;
  if (!is_in_shadow) {
    light += static_cast<float>(std::max(0.0, normal.dot(lighting_.to_sun))) * lighting_.sun;
  }
  return light;
}

Renderer::Shade Renderer::Trace(const Vector3d& eye, const Beam& beam) const {
  const std::optional<Hit> hit = scene_.FindFirstHit(eye, beam.ray);
  if (!hit) return {SkyColour(beam.ray), kSkySurface};
  const Surface& surface = surfaces_[hit->quad];
  const Vector3d place = eye + hit->distance * beam.ray;
  const double plane_distance = surface.normal.dot(surface.corner - eye);
  const auto texture_place = [&](const Vector3d& x) -> Vector2f {
    const TextureArea& area = surface.material.area;
    const Vector3d offset = x - surface.corner;
    return {static_cast<float>(area.u0 + (area.u1 - area.u0) * offset.dot(surface.to_right)),
            static_cast<float>(area.v0 + (area.v1 - area.v0) * offset.dot(surface.to_down))};
  };
  const Vector2f centre = texture_place(place);
  const Footprint footprint{
      centre,
      texture_place(MeetPlane(eye, beam.right, surface.normal, plane_distance, place)) - centre,
      texture_place(MeetPlane(eye, beam.below, surface.normal, plane_distance, place)) - centre};
  const Colour colour = city_->textures[surface.material.texture].Sample(footprint);

  const Vector3d normal =
      surface.normal.dot(beam.ray) < 0 ? surface.normal : Vector3d(-surface.normal);
  const bool faces_sun = lighting_.sun.maxCoeff() > 0 && normal.dot(lighting_.to_sun) > 0;
  const bool is_in_shadow =
      !faces_sun || scene_.IsBlocked(place + kShadowLift * normal, lighting_.to_sun, kShadowReach);
  const Vector3f light = Illuminate(place, normal, is_in_shadow);
  const float glow = lighting_.window_light * colour[3] / 255;
  Vector3f seen;
  for (int c = 0; c < 3; ++c) {
    seen[c] = colour[static_cast<std::size_t>(c)] * std::max(Display(light[c]), glow);
  }
  const bool shows_shadow = faces_sun && is_in_shadow;
  return {seen, 2 * surface.id + (shows_shadow ? 1U : 0U)};
}

Radiance Renderer::Render(const ViewRays& rays, const Rigid3& world_from_camera,
                          Antialiasing antialiasing) const {
  const int width = rays.width_px();
  const int height = rays.height_px();
  const Eigen::Matrix3d turn = world_from_camera.rotation().toRotationMatrix();
  const Vector3d& eye = world_from_camera.translation();
  const auto pixel = [&](int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column);
  };
  const auto beam_at = [&](int column, int row) {
    return Beam{turn * rays.At(column, row), turn * rays.At(column + 1, row),
                turn * rays.At(column, row + 1)};
  };
  Radiance image{width, height, std::vector<float>(3 * pixel(0, height))};
  std::vector<std::uint32_t> surfaces(pixel(0, height));
  const auto put = [&](std::size_t at, const Vector3f& colour) {
    for (int c = 0; c < 3; ++c) image.values[3 * at + static_cast<std::size_t>(c)] = colour[c];
  };
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const Shade shade = Trace(eye, beam_at(column, row));
      surfaces[pixel(column, row)] = shade.surface;
      put(pixel(column, row), shade.colour);
    }
  }
  if (antialiasing == Antialiasing::kNone) return image;
  const auto is_edge = [&](int column, int row) {
    const std::uint32_t own = surfaces[pixel(column, row)];
    return (column > 0 && surfaces[pixel(column - 1, row)] != own) ||
           (column + 1 < width && surfaces[pixel(column + 1, row)] != own) ||
           (row > 0 && surfaces[pixel(column, row - 1)] != own) ||
           (row + 1 < height && surfaces[pixel(column, row + 1)] != own);
  };
  constexpr std::array<std::array<double, 2>, 4> kOffsets{
      // a rotated grid
      {{-0.375, -0.125}, {0.125, -0.375}, {0.375, 0.125}, {-0.125, 0.375}}};
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      if (antialiasing == Antialiasing::kEdges && !is_edge(column, row)) continue;
      const Beam whole = beam_at(column, row);
      const Vector3d right = whole.right - whole.ray;
      const Vector3d below = whole.below - whole.ray;
      Vector3f sum = Vector3f::Zero();
      for (const auto& [x, y] : kOffsets) {
        const Vector3d ray = whole.ray + x * right + y * below;
        sum += Trace(eye, {ray, ray + right / 2, ray + below / 2}).colour;
      }
      put(pixel(column, row), sum / 4);
    }
  }
  return image;
}

DepthImage Renderer::RenderDepth(const ViewRays& rays, const Rigid3& world_from_camera) const {
  DepthImage image{rays.width_px(), rays.height_px(), {}};
  image.depth_m.reserve(static_cast<std::size_t>(image.width_px) *
                        static_cast<std::size_t>(image.height_px));
  for (int row = 0; row < image.height_px; ++row) {
    for (int column = 0; column < image.width_px; ++column) {
      // Rays have z = 1 in the camera, so their parameter is the depth.
      const auto hit = scene_.FindFirstHit(world_from_camera.translation(),
                                           world_from_camera.rotation() * rays.At(column, row));
      image.depth_m.push_back(hit ? hit->distance : 0);
    }
  }
  return image;
}

std::optional<Vector3d> Renderer::FindSurface(const Vector3d& origin,
                                              const Vector3d& direction) const {
  const auto hit = scene_.FindFirstHit(origin, direction);
  if (!hit) return std::nullopt;
  return origin + hit->distance * direction;
}

}  // namespace waymark::simulator
