// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "examples/simulator/render/renderer.h"

namespace waymark::simulator {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kGamma = 2.2F;
constexpr double kLampReach = 25;   // metres; beyond it a lamp gives less than the night's sky
constexpr double kLampHead = 0.5;   // metres; a lamp does not stand in its own light
constexpr double kLampLift = 0.01;  // metres off the surface

Vector3f ToLinear(const Vector3f& display) {
  return (display / 255).array().max(0.0F).pow(kGamma).matrix();
}

Vector3f ToDisplay(const Vector3f& linear) {
  return 255 * linear.array().max(0.0F).pow(1 / kGamma).matrix();
}

/// Where water stands on the ground instead of only wetting it.
bool IsPuddle(const Vector3d& place) {
  const double x = place.x();
  const double y = place.y();
  return std::sin(1.7 * x + std::sin(0.9 * y)) * std::sin(1.3 * y + 1.1 * std::sin(0.7 * x)) > 0.55;
}

}  // namespace

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
  if (lighting_.lamp.maxCoeff() > 0) light += LampLight(place, normal);
  return light;
}

Vector3f Renderer::LampLight(const Vector3d& place, const Vector3d& normal) const {
  double sum = 0;
  for (const Vector3d& lamp : city_->lamps) {
    const Vector3d to_lamp = lamp - place;
    const double distance = to_lamp.norm();
    const double facing = normal.dot(to_lamp) / distance;
    if (distance > kLampReach || facing <= 0) continue;
    const double clear = std::max(0.0, distance - kLampHead);
    if (scene_.IsBlocked(place + kLampLift * normal, to_lamp / distance, clear)) continue;
    sum += facing / (distance * distance);
  }
  return static_cast<float>(sum) * lighting_.lamp;
}

Vector3f Renderer::Wet(const Vector3f& dry, const Vector3d& eye, const Beam& beam,
                       double distance) const {
  const Vector3d place = eye + distance * beam.ray;
  const double length = beam.ray.norm();
  const double facing = std::abs(beam.ray.z()) / length;
  // Schlick's approximation for water.
  const auto mirrored_share = static_cast<float>(0.02 + 0.98 * std::pow(1 - facing, 5.0));
  // Rough asphalt draws mirror images out downwards, rain ripples puddles: three looks up.
  const double spread = IsPuddle(place) ? 0.012 : 0.14;
  const double ripple = 0.3 * spread * std::sin(41 * place.x() + 3 * std::sin(29 * place.y()));
  const auto mirror = [&](const Vector3d& ray, double tilt) -> Vector3d {
    return {ray.x(), ray.y(), std::max(-ray.z() + (tilt + ripple) * length, 1e-3 * length)};
  };
  constexpr double kLift = 1 + 1e-4;  // off the ground that mirrors
  Vector3f mirrored = Vector3f::Zero();
  for (const double tilt : {-spread, 0.0, spread}) {
    const Beam up{mirror(beam.ray, tilt), mirror(beam.right, tilt), mirror(beam.below, tilt)};
    mirrored += ToLinear(Trace(place - distance * up.ray, up, kLift * distance).colour) / 3;
  }
  const float darkening = 1 - 0.5F * lighting_.wetness;
  const Vector3f diffuse = darkening * ToLinear(dry);
  return ToDisplay(diffuse + lighting_.wetness * mirrored_share * (mirrored - diffuse));
}

void Renderer::AddGlare(const ViewRays& rays, const Rigid3& world_from_camera,
                        Radiance& image) const {
  if (lighting_.glare == 0) return;
  const Vector3d& eye = world_from_camera.translation();
  const Vector3d to_sun = world_from_camera.rotation().conjugate() * lighting_.to_sun;
  if (to_sun.z() < 0.2 || scene_.IsBlocked(eye, lighting_.to_sun, kSunReach)) return;
  // The Stiles-Holladay law: a source that gives E lux veils what is seen theta degrees beside it
  // by 10 E / theta^2 cd/m^2. White that it lights has E / pi.
  const Vector3f strength = 10 * std::numbers::pi_v<float> * lighting_.glare * lighting_.sun;
  std::size_t at = 0;
  for (int row = 0; row < image.height_px; ++row) {
    for (int column = 0; column < image.width_px; ++column, at += 3) {
      const double cosine = rays.At(column, row).normalized().dot(to_sun);
      const double degrees = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
      const auto veil = static_cast<float>(1 / std::max(1.0, degrees * degrees));
      Eigen::Map<Vector3f> pixel(&image.values[at]);
      pixel = ToDisplay(ToLinear(pixel) + veil * strength);
    }
  }
}

}  // namespace waymark::simulator
