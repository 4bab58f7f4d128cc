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
constexpr double kShadowLift = 0.004;   // metres off the surface, above float error at 200 m
constexpr double kHighestGround = 0.2;  // metres; above it lie roofs and tables

/// Where a neighbouring ray meets the plane of the surface; itself where it runs away from it.
Vector3d MeetPlane(const Vector3d& eye, const Vector3d& ray, const Vector3d& normal,
                   double plane_distance, const Vector3d& fallback) {
  const double slope = normal.dot(ray);
  if (std::abs(slope) < 1e-9 * ray.norm()) return fallback;
  const double distance = plane_distance / slope;
  return distance > 0 ? Vector3d(eye + distance * ray) : fallback;
}

/// Display values carry gamma 2.2, so light multiplies them by its 2.2th root. Tabulated over [0,
/// 2], more than any preset shines.
float Display(float linear) {
  constexpr int kSteps = 4096;
  static const auto table = [] {
    std::array<float, kSteps + 1> roots{};
    for (int i = 0; i <= kSteps; ++i) {
      roots[static_cast<std::size_t>(i)] =
          std::pow(2 * static_cast<float>(i) / static_cast<float>(kSteps), 1 / 2.2F);
    }
    return roots;
  }();
  const float position = std::clamp(linear, 0.0F, 2.0F) * (kSteps / 2);
  return table[static_cast<std::size_t>(position + 0.5F)];
}

}  // namespace

/// One sample per pixel, before edges are smoothed.
class Renderer::Raster {
 public:
  Raster(int width, int height)
      : width_(width),
        height_(height),
        shades_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

  std::size_t size() const { return shades_.size(); }
  Shade& At(int column, int row) {
    return shades_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(column)];
  }
  /// Whether a surface or shadow ends here in a way that can be seen.
  bool IsEdge(int column, int row) {
    const Shade& own = At(column, row);
    const auto ends_at = [&](const Shade& other) {
      constexpr float kVisible = 30;  // levels, summed over channels
      return other.surface != own.surface && (other.colour - own.colour).lpNorm<1>() > kVisible;
    };
    return (column > 0 && ends_at(At(column - 1, row))) ||
           (column + 1 < width_ && ends_at(At(column + 1, row))) ||
           (row > 0 && ends_at(At(column, row - 1))) ||
           (row + 1 < height_ && ends_at(At(column, row + 1)));
  }

 private:
  int width_;
  int height_;
  std::vector<Shade> shades_;
};

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

Renderer::Shade Renderer::Trace(const Vector3d& eye, const Beam& beam, double start) const {
  std::optional<Hit> hit = scene_.FindFirstHit(eye + start * beam.ray, beam.ray);
  if (!hit) return {SkyColour(beam.ray), kSkySurface};
  hit->distance += start;
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
      !faces_sun || scene_.IsBlocked(place + kShadowLift * normal, lighting_.to_sun, kSunReach);
  const Vector3f light = Illuminate(place, normal, is_in_shadow);
  const float glow = lighting_.window_light * colour[3] / 255;
  Vector3f seen;
  for (int c = 0; c < 3; ++c) {
    seen[c] = colour[static_cast<std::size_t>(c)] * std::max(Display(light[c]), glow);
  }
  if (lighting_.wetness > 0 && normal.z() > 0.95 && place.z() < kHighestGround) {
    seen = Wet(seen, eye, beam, hit->distance);
  }
  if (lighting_.haze_per_m > 0) {
    const double air_m = (hit->distance - start) * beam.ray.norm();
    seen = lighting_.horizon +
           std::exp(-lighting_.haze_per_m * static_cast<float>(air_m)) * (seen - lighting_.horizon);
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
  Raster raster(width, height);
  for (int row = 0; row < height; ++row) {
    Vector3d next = turn * rays.At(0, row);
    for (int column = 0; column < width; ++column) {
      const Vector3d ray = next;
      next = turn * rays.At(column + 1, row);
      raster.At(column, row) = Trace(eye, {ray, next, turn * rays.At(column, row + 1)});
    }
  }
  constexpr std::array<std::array<double, 2>, 4> kRotatedGrid{
      {{-0.375, -0.125}, {0.125, -0.375}, {0.375, 0.125}, {-0.125, 0.375}}};
  Radiance image{width, height, {}};
  image.values.reserve(3 * raster.size());
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      Vector3f colour = raster.At(column, row).colour;
      if (antialiasing == Antialiasing::kFull ||
          (antialiasing == Antialiasing::kEdges && raster.IsEdge(column, row))) {
        const Vector3d ray = turn * rays.At(column, row);
        const Vector3d right = turn * rays.At(column + 1, row) - ray;
        const Vector3d below = turn * rays.At(column, row + 1) - ray;
        colour.setZero();
        for (const auto& [x, y] : kRotatedGrid) {
          const Vector3d part = ray + x * right + y * below;
          colour += Trace(eye, {part, part + right / 2, part + below / 2}).colour / 4;
        }
      }
      image.values.insert(image.values.end(), {colour[0], colour[1], colour[2]});
    }
  }
  AddGlare(rays, world_from_camera, image);
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
